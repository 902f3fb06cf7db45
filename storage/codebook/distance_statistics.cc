#include "storage/codebook/distance_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

constexpr double kQuantileStep = 0.05;
constexpr size_t kNumQuantiles = 19;

}  // namespace

double SameLandmarkDistance(const Codebook& codebook, double quantile) {
  const std::vector<float>& distances = codebook.same_landmark_distance_quantiles;
  if (distances.size() != kNumQuantiles) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("codebook {} has {} same-landmark distance quantiles instead of {}; "
                            "ingest the map again",
                            Value(codebook.id), distances.size(), kNumQuantiles));
  }
  const double position = std::clamp(quantile / kQuantileStep - 1.0, 0.0, kNumQuantiles - 1.0);
  const size_t below = std::min(static_cast<size_t>(position), kNumQuantiles - 2);
  return std::lerp(static_cast<double>(distances[below]), static_cast<double>(distances[below + 1]),
                   position - static_cast<double>(below));
}

}  // namespace cairn
