// Finds the blobs of an octave: extrema of the differences of Gaussians (Lowe 2004, sections 3, 4).
#ifndef CAIRN_INGEST_FEATURES_SIFT_DETECTOR_H_
#define CAIRN_INGEST_FEATURES_SIFT_DETECTOR_H_

#include <vector>

#include "ingest/features/scale_space.h"

namespace cairn {

// In pixels of the octave; (0, 0) is the centre of its upper left pixel.
struct SiftExtremum {
  float x_px = 0.0f;
  float y_px = 0.0f;
  float sigma_px = 0.0f;  // Of the Gaussian, SiftSigmaPx of the refined level.
  int level = 0;          // The Gaussian of ScaleSpaceOctave::levels that it was found beside.
  float contrast = 0.0f;  // Of the difference of Gaussians, grey levels; the sign is dropped.
};

struct SiftDetectorOptions {
  // Of the refined extremum, of the 255 grey levels. COLMAP's, also below.
  double contrast_threshold = 0.02 / kSiftLevelsPerOctave;
  double edge_threshold = 10.0;  // Ratio of the principal curvatures.
};

// By level, row and column. Refined by up to five Newton steps across pixels, as VLFeat does it.
std::vector<SiftExtremum> DetectSiftExtrema(const ScaleSpaceOctave& octave,
                                            const SiftDetectorOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SIFT_DETECTOR_H_
