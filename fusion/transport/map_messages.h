// Encodes queries and decodes answers as the server's POST /v1/localize defines them
// (docs/http.md).
#ifndef CAIRN_FUSION_TRANSPORT_MAP_MESSAGES_H_
#define CAIRN_FUSION_TRANSPORT_MAP_MESSAGES_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/geodesy.h"
#include "fusion/estimator/fusion_types.h"

namespace cairn::fusion {

// A rough position from another source, in the form that GPS receivers report.
struct RoughPosition {
  Geodetic position;
  double accuracy_m = 15.0;  // Radius that holds the true position with 68 %; positive.
};

// A query of the filter together with the frame's features, which only the application has.
struct MapQuery {
  Query request;
  Camera camera;
  // Features projected by the map's codebook, which `codec` then names, or raw features. Keypoints
  // lie in the image.
  FeatureSet features;
  std::string codec;
  // For each keypoint, the track it belongs to, if any. Empty: no keypoint belongs to a track.
  std::vector<std::optional<uint64_t>> track_of_keypoint;
  // Used as long as the filter has no prior of its own. With neither, the server searches the whole
  // map.
  std::optional<RoughPosition> rough_position;
};

// A request body, its Content-Type, and the name of the cell (core/cell_name.h) of the query's
// prior, which is empty if there is no prior.
struct MapRequest {
  std::string content_type;
  std::string body;
  std::string cell;
};

// Encodes a query as multipart/form-data. The geometry of the features is compact; projected
// descriptors are float16. A query of 500 features with 16 dimensions takes 22 kB, of which the
// features take 20 kB. `global` is the east-north-up frame at `global_origin`. Throws
// Error(kBadInput) if the features are invalid or not in the image.
MapRequest MakeMapRequest(const MapQuery& query, const Geodetic& global_origin, int timeout_ms,
                          int max_matches);

// Decodes the answer to `query` from the JSON of a response with status 200, and transforms it to
// the `global` frame. Returns nullopt if the text is not such a JSON or contains an impossible
// number. A match whose keypoint is not in the query loses only its track. Takes the first
// `max_matches` matches: the server was asked for no more.
std::optional<Answer> ReadMapAnswer(std::string_view json, const MapQuery& query,
                                    const Geodetic& global_origin, int max_matches) noexcept;

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRANSPORT_MAP_MESSAGES_H_
