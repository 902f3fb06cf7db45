// A request to POST /v1/localize as JSON, in both directions. The clients write it, and the server
// reads it.
#ifndef CAIRN_CORE_WIRE_WIRE_REQUEST_H_
#define CAIRN_CORE_WIRE_WIRE_REQUEST_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/focal_length.h"
#include "core/position_prior.h"
#include "core/rig_camera.h"
#include "core/wire/inner_frame.h"
#include "core/wire/json_reader.h"

namespace cairn {

inline constexpr int kMaxTimeoutMs = 60'000;  // Largest timeout that a request may ask for.
inline constexpr int kMaxMatches = 100'000;   // Largest number of matches in a response.
inline constexpr size_t kMaxIdLength = 128;
inline constexpr char kTimeoutMember[] = "timeoutMs";  // The name of the timeout.

// A photo file stores pixels as the sensor read them; its EXIF states how to turn them upright.
// Camera parameters, gravity, matches and pose all refer to one of these two pictures.
enum class ImageOrientation {
  kAsSize,   // The one that has the stated size; the stored picture if both have.
  kStored,   // The pixels as stored in the file.
  kUpright,  // The picture as its EXIF turns it.
};

// The names are "stored" and "upright". A request without a name means kAsSize.
std::optional<ImageOrientation> ImageOrientationFromName(std::string_view name);
const char* ImageOrientationName(ImageOrientation orientation);  // kAsSize has no name.

// The contents that the client wants in the response.
struct ResponseOptions {
  InnerFrame inner_frame = InnerFrame::kFlu;
  int max_matches = 200;
  bool with_matches = false;
  bool with_timings = true;
  bool with_covariance = true;
};

// A request without its images and features, which are members of the JSON or parts of a multipart
// body.
struct WireRequest {
  std::string id = {};                       // At most kMaxIdLength bytes.
  std::optional<int64_t> timestamp_ms = {};  // When the picture was taken, since the Unix epoch.
  Camera camera = {};
  std::optional<FocalPrior> focal = {};       // As LocalizeQuery::focal.
  std::vector<RigCamera> other_cameras = {};  // Without features; at most RigCamera::kMaxOthers.
  std::optional<PositionPrior> prior = {};    // From PriorSource::kClient.
  std::optional<Eigen::Vector3d> down_in_cam = {};       // Unit vector.
  std::optional<int> timeout_ms = {};                    // Without one, the server's default.
  ImageOrientation picture = ImageOrientation::kAsSize;  // The picture that the request describes.
  // Without a prior, the position in the EXIF of the first image is the prior.
  bool exif_prior = true;
  ResponseOptions answer = {};
};

// Members with default values are left out where older servers do not know them. Bytes of the id
// that are not UTF-8 are replaced.
std::string WireRequestJson(const WireRequest& request);

// Reads and checks everything but `image` and `features`, which may be there. Throws JsonError with
// the pointer of the member at fault, also for unknown members, and what Geoid::Egm96 throws if a
// height is above mean sea level.
WireRequest ReadWireRequest(const JsonReader& json);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_WIRE_REQUEST_H_
