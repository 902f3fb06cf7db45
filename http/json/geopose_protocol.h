// Open AR Cloud GeoPoseProtocol 2.0 (https://github.com/OpenArCloud/oscp-geopose-protocol).
#ifndef CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_
#define CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_

#include <string>
#include <string_view>

#include "engine/query/localize_result.h"
#include "http/json/localize_request.h"

namespace cairn {

// Reads a GeoPoseRequest of version 2. The first camera reading that is a picture is the query's;
// pictures that other cameras of its rig took at the same time make it a query of a rig. What
// `size` and `params` leave out is taken from the picture and its EXIF. Position and gravity are as
// http/json/geopose_readings.h says. Members that this server does not use are ignored, as the
// protocol is open. The reference clients leave what they do not know at 0: an accuracy of 0 means
// unknown (25 m is assumed), an altitude accuracy of 0 that the altitude is not to be trusted.
// Throws as ParseLocalizeRequest; a request of version 1 is refused with these words.
LocalizeRequest ParseGeoPoseRequest(std::string_view content_type, std::string_view body,
                                    const RequestLimits& limits);

// The GeoPoseResponse of a result that is localized. The inner frame is FLU, of the picture as the
// request's imageOrientation turns it.
std::string GeoPoseResponseJson(const LocalizeResult& result, const LocalizeRequest& request);

// Its pose alone: an OGC GeoPose 1.0 Basic-Quaternion, of the type application/geopose+json.
std::string OgcGeoPoseJson(const LocalizeResult& result, const LocalizeRequest& request);

// True if an Accept header asks for that type.
bool WantsOgcGeoPose(std::string_view accept);

// The protocol's media type if the client's Accept header asks for it, else application/json.
// Reference clients send "application/vnd.oscp+json;version=2.0;" with the semicolon at the end.
std::string GeoPoseContentType(std::string_view accept);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_
