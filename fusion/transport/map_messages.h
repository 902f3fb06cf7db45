// Queries and answers of the filter, as the server's POST /v1/localize speaks them (docs/http.md).
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
#include "fusion/client/fusion_types.h"

namespace cairn::fusion {

// A rough position from elsewhere, as GPS receivers report it.
struct RoughPosition {
  Geodetic position;
  double accuracy_m = 15.0;  // Radius that holds the truth with 68 %, positive.
};

// The filter's question with what only the application has: the features of the frame.
struct MapQuery {
  Query query;
  Camera camera;
  // Projected by the map's codebook (then `codec` names it), or raw. Keypoints lie in the image.
  FeatureSet features;
  std::string codec;
  // For each keypoint the track it is a sight of, if any. Empty: none is.
  std::vector<std::optional<uint64_t>> track_of_keypoint;
  // Used while the filter has no prior of its own. With neither, the whole map is searched.
  std::optional<RoughPosition> rough_position;
};

// A body and its Content-Type.
struct MapRequest {
  std::string content_type;
  std::string body;
};

// The request of a query: multipart/form-data, features with compact geometry, projected ones as
// float16: 22 kB for 500 features of 16 dimensions (20 kB of them the features). `global` is the
// east-north-up frame at `global_origin`. Throws Error(kBadInput) if the features are not valid or
// do not lie in the image.
MapRequest MakeMapRequest(const MapQuery& query, const Geodetic& global_origin, int timeout_ms,
                          int max_matches);

// The answer to `query` from the JSON of a response of status 200, moved to the `global` frame.
// Nothing if it is not such a JSON, or a number makes no sense; matches that name no keypoint of
// the query lose their track only.
std::optional<Answer> ReadMapAnswer(std::string_view json, const MapQuery& query,
                                    const Geodetic& global_origin) noexcept;

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRANSPORT_MAP_MESSAGES_H_
