#include "engine/pose/pose_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"

namespace cairn {
namespace {

void Require(bool condition, const char* what) {
  if (!condition) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("pose option {}", what));
  }
}

}  // namespace

void ConsensusOptions::Validate() const {
  Require(max_rejected_share > 0.0 && max_rejected_share < 1.0,
          "consensus.max_rejected_share must lie in (0, 1)");
}

void PoseOptions::Validate() const {
  consensus.Validate();
  Require(max_error_px > 0.0 && max_error_px <= 1000.0, "max_error_px must lie in (0, 1000]");
  Require(keypoint_sigma_px > 0.0 && keypoint_sigma_px <= 1000.0,
          "keypoint_sigma_px must lie in (0, 1000]");
  Require(min_iterations >= 1, "min_iterations must be at least 1");
  Require(max_iterations >= min_iterations, "max_iterations must be at least min_iterations");
  Require(success_probability > 0.0 && success_probability < 1.0,
          "success_probability must lie in (0, 1)");
  Require(distance_weight >= 0.0 && distance_weight <= 1000.0,
          "distance_weight must lie in [0, 1000]");
  Require(num_local_optimizations >= 1, "num_local_optimizations must be at least 1");
  Require(min_inliers >= 4, "min_inliers must be at least 4");
  Require(gravity_sigma_rad > 0.0 && gravity_sigma_rad <= 0.5,
          "gravity_sigma_rad must lie in (0, 0.5]");
}

double PoseOptions::MaxErrorPx(double focal_px) const {
  constexpr double kReferenceFocalPx = 500.0;
  constexpr double kMinErrorPx = 2.0;
  return std::max(kMinErrorPx, max_error_px * focal_px / kReferenceFocalPx);
}

}  // namespace cairn
