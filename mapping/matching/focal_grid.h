// What pairs of photos say about the focal lengths of their cameras, on a grid of focal lengths.
// Private to mapping/matching.
#ifndef CAIRN_MAPPING_MATCHING_FOCAL_GRID_H_
#define CAIRN_MAPPING_MATCHING_FOCAL_GRID_H_

#include <array>
#include <optional>
#include <span>

#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn {

// The steps are equal in the logarithm: from 0.41 to 3.86 times the focal length of the set's
// camera. If that is the assumed one (CameraOfUnknownFocal), from 12 to 118 mm for 35 mm film.
inline constexpr int kNumFocalSteps = 16;
// The step of the set's own focal length.
inline constexpr int kOwnFocalStep = 6;

double FocalFactorOf(int step);

using FocalCosts = std::array<double, kNumFocalSteps>;

// What a pair says: how much worse its inliers fit than under its best focal lengths.
struct PairVerdict {
  int camera_a = 0, camera_b = 0;
  // Whether the focal length of the camera is asked for; else that of the set holds.
  bool is_free_a = false, is_free_b = false;
  // [step of a][step of b]; one step for a camera that is not free, and the diagonal alone (as
  // [step][0]) if both photos have one camera.
  std::array<std::array<float, kNumFocalSteps>, kNumFocalSteps> costs;

  double CostAt(int step_a, int step_b) const {
    return costs[is_free_a ? step_a : 0][is_free_b && camera_a != camera_b ? step_b : 0];
  }
};

// `cameras` take the place of the set's.
PairVerdict JudgePair(const PhotoSet& set, std::span<const MappingCamera> cameras,
                      const TwoView& view, bool is_free_a, bool is_free_b);

struct KnownFocal {
  double factor = 1.0;
  double log_sigma = 0.0;
};

// The vertex of the parabola through the least cost and its neighbors. Nothing if the costs do not
// tell the focal length.
std::optional<KnownFocal> VertexOf(const FocalCosts& costs);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_FOCAL_GRID_H_
