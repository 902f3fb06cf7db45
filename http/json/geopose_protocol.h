// Open AR Cloud GeoPoseProtocol 2.0 (https://github.com/OpenArCloud/oscp-geopose-protocol).
#ifndef CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_
#define CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_

#include <string>
#include <string_view>

#include "engine/localize_result.h"
#include "http/json/localize_request.h"

namespace cairn {

// Reads a GeoPoseRequest: the first camera reading with its parameters, and the first geolocation
// reading. Members that this server does not use are ignored, as the protocol is open. The
// reference clients leave what they do not know at 0: an accuracy of 0 means unknown (25 m is
// assumed), an altitude accuracy of 0 that the altitude is not to be trusted. Throws as
// ParseLocalizeRequest.
LocalizeRequest ParseGeoPoseRequest(std::string_view content_type, std::string_view body,
                                    const RequestLimits& limits);

// The GeoPoseResponse of a result that is localized. The inner frame is FLU.
std::string GeoPoseResponseJson(const LocalizeResult& result, const LocalizeRequest& request);

// The protocol's media type if the client's Accept header asks for it, else application/json.
// Reference clients send "application/vnd.oscp+json;version=2.0;" with the semicolon at the end.
std::string GeoPoseContentType(std::string_view accept);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_GEOPOSE_PROTOCOL_H_
