// A query of the filter in the street that http/server_fixture.h serves.
#ifndef CAIRN_TESTS_FUSION_STREET_QUERY_H_
#define CAIRN_TESTS_FUSION_STREET_QUERY_H_

#include "engine/query/localize_query.h"
#include "fusion/transport/map_messages.h"
#include "storage/codebook/codebook.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/map/map_store.h"

namespace cairn::fusion::testing {

// Returns the query with raw features.
inline MapQuery MapQueryFrom(const LocalizeQuery& from, int64_t query_id) {
  MapQuery query;
  query.request.query_id = query_id;
  query.request.down_in_cam = *from.down_in_cam;
  query.camera = from.camera;
  query.features = from.features;
  query.rough_position = {from.prior->position, from.prior->accuracy_m};
  return query;
}

// Returns the query with features projected by the map's codebook, as a phone sends them.
inline MapQuery ProjectedMapQueryFrom(const LocalizeQuery& from, int64_t query_id,
                                      const std::string& map_path) {
  MapQuery query = MapQueryFrom(from, query_id);
  const MapStore store = MapStore::Open(map_path, OpenMode::kReadOnly);
  const auto codebook = store.Snapshot().CurrentCodebook();
  query.features.descriptors = DescriptorCodec(codebook).ProjectFeatures(from.features);
  query.features.space = DescriptorSpace::kProjected;
  query.codec = codebook->CodecName();
  return query;
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_STREET_QUERY_H_
