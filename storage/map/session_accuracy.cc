#include "storage/map/session_accuracy.h"

#include <cmath>

#include "core/check.h"

namespace cairn {

bool IsValid(const SessionAccuracy& accuracy) {
  constexpr double kMax = 1e7;
  const auto is_valid = [](double value) { return value >= 0.0 && value < kMax; };
  return is_valid(accuracy.in_map_m) && is_valid(accuracy.on_earth_m) &&
         is_valid(accuracy.on_earth_rad);
}

SessionAccuracy RootMeanSquare(const std::vector<SessionAccuracy>& accuracies) {
  CAIRN_CHECK(!accuracies.empty(), "a mean needs a value");
  const auto mean = [&](double SessionAccuracy::*member) {
    double sum = 0.0;
    for (const SessionAccuracy& accuracy : accuracies) {
      sum += accuracy.*member * accuracy.*member;
    }
    return std::sqrt(sum / static_cast<double>(accuracies.size()));
  };
  return {mean(&SessionAccuracy::in_map_m), mean(&SessionAccuracy::on_earth_m),
          mean(&SessionAccuracy::on_earth_rad)};
}

}  // namespace cairn
