// The member `options` of POST /v1/localize.
#ifndef CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_
#define CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_

#include <optional>

#include "http/json/image_orientation.h"
#include "http/json/localize_request.h"
#include "http/wire/json_reader.h"

namespace cairn {

// Sets the timeout and the wanted contents of the response. Throws HttpError kInvalidField, also
// for unknown members.
void ReadOptions(const JsonReader& json, LocalizeRequest* request);

// Reads which picture the request describes.
ImageOrientation ReadImageOrientation(const std::optional<JsonReader>& options);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_
