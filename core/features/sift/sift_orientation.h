// The dominant gradient directions around a keypoint (Lowe 2004, section 5).
#ifndef CAIRN_CORE_FEATURES_SIFT_SIFT_ORIENTATION_H_
#define CAIRN_CORE_FEATURES_SIFT_SIFT_ORIENTATION_H_

#include <array>

#include "core/features/sift/scale_space.h"
#include "core/features/sift/sift_detector.h"

namespace cairn {

// The same limit as in COLMAP. Most keypoints have one orientation.
inline constexpr int kMaxSiftOrientations = 2;

struct SiftOrientations {
  int num = 0;
  // The first peaks of the histogram, starting at angle 0, in [0, 2 pi]. The x axis is 0 and the y
  // axis is pi/2.
  std::array<float, kMaxSiftOrientations> angles_rad = {};
};

// Finds the peaks of the histogram of directions within 4.5 sigma that reach at least 0.8 of the
// maximum, as in VLFeat. Finds none if there are no gradients.
SiftOrientations FindSiftOrientations(const ScaleSpaceOctave& octave, const SiftExtremum& extremum);

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_SIFT_ORIENTATION_H_
