// An octave of the scale space of SIFT (Lowe 2004): an image at growing blur.
#ifndef CAIRN_INGEST_FEATURES_SCALE_SPACE_H_
#define CAIRN_INGEST_FEATURES_SCALE_SPACE_H_

#include <vector>

#include "ingest/features/float_image.h"

namespace cairn {

inline constexpr int kSiftLevelsPerOctave = 3;
inline constexpr double kSiftBaseSigmaPx = 1.6;
// Of a sharp image, in its own pixels, as Lowe and COLMAP assume it.
inline constexpr double kSharpSigmaPx = 0.5;

// The blur of a level, which may lie between two, in pixels of its octave.
double SiftSigmaPx(double level);

// The levels at which an octave has keypoints. Finer ones than 1 belong to the octave before.
struct SiftLevels {
  int first = 1;
  int last = kSiftLevelsPerOctave;
};

// Keypoints of a level are found in the differences between one Gaussian below it and two above,
// which are subtracted where they are needed: writing them costs more.
struct ScaleSpaceOctave {
  SiftLevels levels;
  std::vector<FloatImage> gaussians;  // Of levels.first - 1 to levels.last + 2.

  // Blurred by SiftSigmaPx(level).
  const FloatImage& Level(int level) const { return gaussians[level - (levels.first - 1)]; }
};

// `image` has pixels of the octave's size and a blur of `sigma_px` of them, less than
// SiftSigmaPx(levels.first - 1).
ScaleSpaceOctave MakeScaleSpaceOctave(const FloatImage& image, double sigma_px,
                                      const SiftLevels& levels = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SCALE_SPACE_H_
