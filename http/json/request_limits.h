// The limits of requests. engine/query has the limits of a query's values, core/wire those of the
// members, of the binary features and of JSON.
#ifndef CAIRN_HTTP_JSON_REQUEST_LIMITS_H_
#define CAIRN_HTTP_JSON_REQUEST_LIMITS_H_

#include <cstddef>

namespace cairn {

// The limits that an operator sets.
struct RequestLimits {
  int max_features = 5000;  // Of all cameras of a query.
  int default_timeout_ms = 2000;
};

inline constexpr size_t kMaxReadings = 1000;  // Of one sensor in a GeoPoseRequest.
// A longer body may wait for its turn before it is parsed; see TakesLongToParse.
inline constexpr size_t kMaxShortJsonBytes = size_t{64} << 10;

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_REQUEST_LIMITS_H_
