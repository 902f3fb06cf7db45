// The answer of POST /v1/localize: from a result to JSON on the server, and back on the client.
#ifndef CAIRN_HTTP_JSON_LOCALIZE_RESPONSE_H_
#define CAIRN_HTTP_JSON_LOCALIZE_RESPONSE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine/query/localize_result.h"
#include "http/json/localize_request.h"

namespace cairn {

// What only the server knows.
struct ServerTimes {
  double decode_seconds = 0.0;   // Of all images; 0 without one.
  double extract_seconds = 0.0;  // Of its features.
};

// The wire form. Departs from LocalizeResult in this: degrees instead of radians; the covariance is
// of (translation, rotation), in the east-north-up frame at the camera instead of the anchor's;
// matches are thinned evenly to ResponseOptions::max_matches.
std::string LocalizeResponseJson(const LocalizeResult& result, const LocalizeRequest& request,
                                 const ServerTimes& times);

// Inverse, as far as the wire carries a result. Throws Error(kBadInput) if it is not such a JSON.
LocalizeResult ParseLocalizeResponse(std::string_view json);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_LOCALIZE_RESPONSE_H_
