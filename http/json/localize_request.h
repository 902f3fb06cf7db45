// Parses the body of POST /v1/localize (JSON or multipart) into a query.
#ifndef CAIRN_HTTP_JSON_LOCALIZE_REQUEST_H_
#define CAIRN_HTTP_JSON_LOCALIZE_REQUEST_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/wire/wire_request.h"
#include "engine/query/localize_query.h"
#include "http/json/request_limits.h"

namespace cairn {

// A picture as sent by the client.
struct RequestImage {
  std::vector<uint8_t>
      bytes;            // Encoded, or raw pixels with the formats GRAY8 and RGBA32; not empty.
  std::string format;   // As the client named it; JPEG, PNG and PNM are recognized anyway.
  int orientation = 1;  // EXIF orientation by which the decoded picture is turned before use.
};

struct LocalizeRequest {
  LocalizeQuery query;                  // Without features as long as there are images.
  std::optional<int64_t> timestamp_ms;  // When the picture was taken, since the Unix epoch; echoed.
  // The images of the query's camera and of the other cameras of its rig, in this order. Empty if
  // there are features.
  std::vector<RequestImage> images;
  // The picture that the request describes; ReadPhotos settles the orientation of each image by it.
  // Empty once the orientations are settled.
  std::optional<ImageOrientation> picture = ImageOrientation::kAsSize;
  // Without a prior, the position in the EXIF of the first image is the prior.
  bool exif_prior = true;
  int timeout_ms = 0;
  ResponseOptions answer;
  // Rotates the frame of the query's camera into the frame of the camera whose pose GeoPoseProtocol
  // returns: a rotation about the optical axis, given by the protocol's imageOrientation.
  Eigen::Quaterniond answer_from_cam = Eigen::Quaterniond::Identity();

  bool has_images() const { return !images.empty(); }
};

// Throws HttpError kUnsupportedMediaType unless `content_type` is JSON or multipart/form-data.
// Throws HttpError kInvalidMultipart, kInvalidFeatures, kTooManyFeatures or kWrongCodec, and
// JsonError with the JSON pointer of the member at fault. Does not look into images; see
// ReadPhotos.
LocalizeRequest ParseLocalizeRequest(std::string_view content_type, std::string_view body,
                                     const RequestLimits& limits);

// ParseLocalizeRequest or ParseGeoPoseRequest.
using BodyParser = LocalizeRequest(std::string_view content_type, std::string_view body,
                                   const RequestLimits& limits);

// True if parsing the body may take more than about 1 ms on one core, so that the body must wait
// for its turn: JSON of more than 64 KiB, and a multipart body of more than 64 KiB that has
// features or base64. The JSON part of a multipart body is always shorter, and photos are not
// decoded by parsing.
bool TakesLongToParse(std::string_view content_type, std::string_view body);

// Guesses the `timeoutMs` of a body without parsing it; returns the default if it finds none.
// The result only bounds how long the body waits for its turn.
int PeekTimeoutMs(std::string_view body, const RequestLimits& limits);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_LOCALIZE_REQUEST_H_
