// The body of POST /v1/localize, JSON or multipart, as a query.
#ifndef CAIRN_HTTP_JSON_LOCALIZE_REQUEST_H_
#define CAIRN_HTTP_JSON_LOCALIZE_REQUEST_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geoid.h"
#include "engine/query/localize_query.h"
#include "http/json/image_orientation.h"
#include "http/json/inner_frame.h"
#include "http/json/json_reader.h"

namespace cairn {

struct RequestLimits {
  int max_features = 5000;
  int default_timeout_ms = 2000;
};

// What the client wants in the answer. `answer_from_cam` is of GeoPoseResponseJson and
// OgcGeoPoseJson only.
struct ResponseOptions {
  InnerFrame inner_frame = InnerFrame::kFlu;
  int max_matches = 200;
  bool with_matches = false;
  bool with_timings = true;
  bool with_covariance = true;
  // From the frame of the query's camera into that of the camera whose pose is answered: a turn
  // about the optical axis by what GeoPoseProtocol's imageOrientation says.
  Eigen::Quaterniond answer_from_cam = Eigen::Quaterniond::Identity();
};

// A picture as the client sent it.
struct RequestImage {
  std::vector<uint8_t>
      bytes;            // Encoded, or raw pixels with the formats GRAY8 and RGBA32; not empty.
  std::string format;   // As the client named it; JPEG, PNG and PNM are recognised anyway.
  int orientation = 1;  // EXIF's number of how the decoded picture is turned before it is used.
};

struct LocalizeRequest {
  LocalizeQuery query;                  // No features yet if there are images.
  std::optional<int64_t> timestamp_ms;  // Of the picture, since the Unix epoch; echoed.
  // Of the query's camera and the others of its rig, in this order; empty if there are features.
  std::vector<RequestImage> images;
  int timeout_ms = 0;
  ResponseOptions answer;

  bool has_images() const { return !images.empty(); }
};

// Throws HttpError kUnsupportedMediaType unless `content_type` is JSON or multipart/form-data, and
// kInvalidJson, kInvalidField, kInvalidMultipart, kInvalidFeatures, kTooManyFeatures with the JSON
// pointer of what is wrong. Images are not decoded.
LocalizeRequest ParseLocalizeRequest(std::string_view content_type, std::string_view body,
                                     const RequestLimits& limits);

// ParseLocalizeRequest or ParseGeoPoseRequest.
using BodyParser = LocalizeRequest(std::string_view content_type, std::string_view body,
                                   const RequestLimits& limits);

// True if parsing the body takes more than about 3 ms of a core's time, so that it has to wait for
// its turn: JSON of more than 64 KiB. The JSON part of a multipart body is never as long.
bool IsLongJson(std::string_view content_type, std::string_view body);

// The `timeoutMs` that a JSON body seems to state, found without parsing; the default if it states
// none. Says how long the body's turn is worth waiting for, nothing else.
int PeekTimeoutMs(std::string_view body, const RequestLimits& limits);

// Parts that GeoPoseProtocol and the command line share.
// Sets how each image is to be turned, by its header and the size of its camera.
void SetOrientations(ImageOrientation meant, LocalizeRequest* request);
// "ellipsoid" or "msl".
HeightReference ReadHeightReference(const JsonReader& name);
// Of an element of `rig`: its members `camera` and `camFromFirst`; without features.
RigCamera ReadRigCamera(const JsonReader& element);
// Strict base64; throws with the pointer of the string.
std::vector<uint8_t> ReadBase64(const JsonReader& text);
// Degrees and metres; checked.
Geodetic ReadGeodetic(const JsonReader& lat, const JsonReader& lon,
                      const std::optional<JsonReader>& h);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_LOCALIZE_REQUEST_H_
