// The member `options` of POST /v1/localize.
#ifndef CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_
#define CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_

#include <optional>

#include "http/json/image_orientation.h"
#include "http/json/json_reader.h"
#include "http/json/localize_request.h"

namespace cairn {

// The longest time that a request may ask for.
inline constexpr int kMaxTimeoutMs = 60'000;

// Sets the timeout and what is wanted in the answer. Throws HttpError kInvalidField, also for
// members that are unknown.
void ReadOptions(const JsonReader& json, LocalizeRequest* request);

// Which picture the request describes.
ImageOrientation ReadImageOrientation(const std::optional<JsonReader>& options);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_
