// Describes the surroundings of a keypoint: histograms of gradients (Lowe 2004, section 6).
#ifndef CAIRN_INGEST_FEATURES_SIFT_DESCRIPTOR_H_
#define CAIRN_INGEST_FEATURES_SIFT_DESCRIPTOR_H_

#include <span>

#include "ingest/features/scale_space.h"
#include "ingest/features/sift_detector.h"

namespace cairn {

inline constexpr int kSiftDim = 128;

// 4 x 4 cells of 3 sigma, row by row in the frame that is turned by `angle_rad`, of 8 directions
// each, in COLMAP's order: against the sense in which angles are measured. Whole numbers up to 255,
// of length 512 or a little less, as OpenCV has them; zero where there is no gradient.
//
// The square of 15 sigma that the cells reach is sampled on a grid that turns with it, so that each
// sample's share of each cell is the same for all keypoints and the time does not depend on sigma.
// Classic SIFT visits all pixels instead; RootSIFT descriptors of both are 0.06 apart in the
// median.
void DescribeSift(const ScaleSpaceOctave& octave, const SiftExtremum& extremum, float angle_rad,
                  std::span<float, kSiftDim> descriptor);

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SIFT_DESCRIPTOR_H_
