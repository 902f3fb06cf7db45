// The direction of a gradient, in a form that compilers can vectorize.
#ifndef CAIRN_CORE_FEATURES_SIFT_ARC_TANGENT_H_
#define CAIRN_CORE_FEATURES_SIFT_ARC_TANGENT_H_

#include <cmath>

namespace cairn {

// Returns atan2(y, x) in units of 45 degrees, in [0, 8], with an error below 0.0002 units; 0 for
// (0, 0).
//
// The polynomial is Abramowitz and Stegun, 4.4.49, converted to these units.
[[gnu::always_inline]] inline float DirectionInEighths(float y, float x) {
  constexpr float kEighthsFromRad = 1.2732395447351628f;
  const float abs_x = std::fabs(x), abs_y = std::fabs(y);
  const float smaller = abs_x < abs_y ? abs_x : abs_y;
  const float larger = (abs_x < abs_y ? abs_y : abs_x) + 1e-20f;
  const float ratio = smaller / larger;
  const float sq = ratio * ratio;
  const float octant =
      kEighthsFromRad * ratio *
      (0.9998660f + sq * (-0.3302995f + sq * (0.1801410f + sq * (-0.0851330f + sq * 0.0208351f))));
  const float quadrant = abs_x < abs_y ? 2.0f - octant : octant;
  const float half = x < 0.0f ? 4.0f - quadrant : quadrant;
  return y < 0.0f ? 8.0f - half : half;
}

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_ARC_TANGENT_H_
