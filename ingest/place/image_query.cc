#include "ingest/place/image_query.h"

namespace cairn {

LocalizeQuery QueryOfImage(const Reconstruction& reconstruction, int image_idx,
                           const Geodetic& about, double accuracy_m, const std::string& codec) {
  const ReconImage& image = reconstruction.images[static_cast<size_t>(image_idx)];
  LocalizeQuery query;
  query.id = image.name;
  query.camera = reconstruction.cameras[static_cast<size_t>(image.camera_idx)];
  query.features = image.features.Unpacked();
  query.codec = codec;
  query.prior.emplace();
  query.prior->position = about;
  query.prior->accuracy_m = accuracy_m;
  return query;
}

}  // namespace cairn
