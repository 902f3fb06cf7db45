// Open AR Cloud GeoPoseProtocol 2.0 (https://github.com/OpenArCloud/oscp-geopose-protocol).
#ifndef CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_
#define CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_

#include <string>
#include <string_view>

#include "engine/query/localize_result.h"
#include "http/json/localize_request.h"

namespace cairn {

// Reads a GeoPoseRequest of version 2.
// - The query's picture is the first camera reading that holds a picture. Pictures that other
//   cameras of its rig took at the same time turn the query into a rig query.
// - Parts that `size` and `params` leave out come from the picture and its EXIF.
// - http/json/geopose_readings.h documents position and gravity.
// - Unknown members are ignored, because the protocol is open.
// - Reference clients send 0 for unknown values. An accuracy of 0 means unknown (25 m is assumed).
//   With an altitude accuracy of 0, the altitude is not used.
// Throws as ParseLocalizeRequest. A request of version 1 is refused with a message that says so.
LocalizeRequest ParseGeoPoseRequest(std::string_view content_type, std::string_view body,
                                    const RequestLimits& limits);

// The GeoPoseResponse of a localized result. The inner frame is FLU, for the picture turned
// according to the request's imageOrientation.
std::string GeoPoseResponseJson(const LocalizeResult& result, const LocalizeRequest& request);

// Only the pose: an OGC GeoPose 1.0 Basic-Quaternion, media type application/geopose+json.
std::string OgcGeoPoseJson(const LocalizeResult& result, const LocalizeRequest& request);

// True if the Accept header prefers application/geopose+json to application/json.
bool WantsOgcGeoPose(std::string_view accept);

// The protocol's media type if the Accept header prefers it, else application/json. Reference
// clients send "application/vnd.oscp+json;version=2.0;", including the final semicolon.
std::string GeoPoseContentType(std::string_view accept);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_
