// The member `options` of POST /v1/localize.
#ifndef CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_
#define CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_

#include "core/wire/json_reader.h"
#include "http/json/localize_request.h"

namespace cairn {

// Sets the timeout, the use of the photos' EXIF and the wanted contents of the response. Throws
// JsonError, also for unknown members.
void ReadOptions(const JsonReader& json, LocalizeRequest* request);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_REQUEST_OPTIONS_H_
