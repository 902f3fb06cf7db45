// Describes the surroundings of a keypoint by histograms of gradients (Lowe 2004, section 6).
#ifndef CAIRN_CORE_FEATURES_SIFT_SIFT_DESCRIPTOR_H_
#define CAIRN_CORE_FEATURES_SIFT_SIFT_DESCRIPTOR_H_

#include <span>

#include "core/features/sift/scale_space.h"
#include "core/features/sift/sift_detector.h"

namespace cairn {

inline constexpr int kSiftDim = 128;

// The descriptor has 4 x 4 cells of 3 sigma, row by row in the frame rotated by `angle_rad`. Each
// cell has 8 directions in COLMAP's order, which runs against the sense of the angles. The values
// are whole numbers up to 255, as in OpenCV, and have a length of 512 or a little less. Without
// gradients, all values are zero.
//
// The cells span a square of 15 sigma. The square is sampled on a grid that rotates with it. The
// share of each sample in each cell is therefore the same for all keypoints, and the time does not
// depend on sigma. Classic SIFT visits all pixels instead. The median distance between RootSIFT
// descriptors of both methods is 0.06.
void DescribeSift(const ScaleSpaceOctave& octave, const SiftExtremum& extremum, float angle_rad,
                  std::span<float, kSiftDim> descriptor);

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_SIFT_DESCRIPTOR_H_
