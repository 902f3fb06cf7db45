// The dominant directions of the gradient around a keypoint (Lowe 2004, section 5).
#ifndef CAIRN_INGEST_FEATURES_SIFT_ORIENTATION_H_
#define CAIRN_INGEST_FEATURES_SIFT_ORIENTATION_H_

#include <array>

#include "ingest/features/scale_space.h"
#include "ingest/features/sift_detector.h"

namespace cairn {

// COLMAP's limit. Most keypoints have one.
inline constexpr int kMaxSiftOrientations = 2;

struct SiftOrientations {
  int num = 0;
  // The first peaks of the histogram, from angle 0 on; x axis is 0, y axis pi/2, in [0, 2 pi].
  std::array<float, kMaxSiftOrientations> angles_rad = {};
};

// Where the histogram of directions within 4.5 sigma is at least 0.8 of its maximum, as VLFeat does
// it. None where there is no gradient.
SiftOrientations FindSiftOrientations(const ScaleSpaceOctave& octave, const SiftExtremum& extremum);

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SIFT_ORIENTATION_H_
