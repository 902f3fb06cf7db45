// The response of POST /v1/localize: the server writes a result as JSON, and the client reads it.
#ifndef CAIRN_HTTP_JSON_LOCALIZE_RESPONSE_H_
#define CAIRN_HTTP_JSON_LOCALIZE_RESPONSE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine/query/localize_result.h"
#include "http/json/localize_request.h"

namespace cairn {

// Times that only the server measures.
struct ServerTimes {
  double decode_seconds = 0.0;   // Of all images; 0 without images.
  double extract_seconds = 0.0;  // Of the features of all images.
};

// Writes the wire form. It differs from LocalizeResult as follows:
// - Angles are in degrees instead of radians.
// - The covariance is of (translation, rotation), in the east-north-up frame at the camera instead
//   of the anchor's frame.
// - Matches are thinned evenly to ResponseOptions::max_matches.
std::string LocalizeResponseJson(const LocalizeResult& result, const LocalizeRequest& request,
                                 const ServerTimes& times);

// Reads the wire form; fields that the wire does not carry keep their defaults. Throws
// Error(kBadInput) if the JSON is not such a response.
LocalizeResult ParseLocalizeResponse(std::string_view json);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_LOCALIZE_RESPONSE_H_
