// Detects the blobs of an octave: extrema of the differences of Gaussians (Lowe 2004, sections 3,
// 4).
#ifndef CAIRN_CORE_FEATURES_SIFT_SIFT_DETECTOR_H_
#define CAIRN_CORE_FEATURES_SIFT_SIFT_DETECTOR_H_

#include <vector>

#include "core/features/sift/scale_space.h"

namespace cairn {

// In pixels of the octave. (0, 0) is the center of the upper left pixel.
struct SiftExtremum {
  float x_px = 0.0f;
  float y_px = 0.0f;
  float sigma_px = 0.0f;  // Blur of the Gaussian: SiftSigmaPx of the refined level.
  int level = 0;          // The nearest Gaussian, a level of ScaleSpaceOctave::levels.
  float contrast = 0.0f;  // Absolute difference of Gaussians, gray levels.
};

struct SiftDetectorOptions {
  // Threshold for the refined extremum, as a share of the 255 gray levels. The default is COLMAP's;
  // tests set 0.
  double contrast_threshold = 0.02 / kSiftLevelsPerOctave;
};

// Returns the extrema in order of level, row and column. Up to five Newton steps across pixels
// refine each extremum, as in VLFeat.
std::vector<SiftExtremum> DetectSiftExtrema(const ScaleSpaceOctave& octave,
                                            const SiftDetectorOptions& options);

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_SIFT_DETECTOR_H_
