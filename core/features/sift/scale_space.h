// An octave of the scale space of SIFT (Lowe 2004): one image at increasing blur.
#ifndef CAIRN_CORE_FEATURES_SIFT_SCALE_SPACE_H_
#define CAIRN_CORE_FEATURES_SIFT_SCALE_SPACE_H_

#include <vector>

#include "core/features/sift/float_image.h"
#include "core/stop_function.h"

namespace cairn {

inline constexpr int kSiftLevelsPerOctave = 3;
inline constexpr double kSiftBaseSigmaPx = 1.6;
// Assumed blur of a sharp image, in its own pixels; the same value as in Lowe 2004 and COLMAP.
inline constexpr double kSharpSigmaPx = 0.5;

// The blur of a level, in pixels of its octave. Fractional levels are allowed.
double SiftSigmaPx(double level);

// The levels at which an octave has keypoints. Levels below 1 belong to the previous octave.
struct SiftLevels {
  int first = 1;
  int last = kSiftLevelsPerOctave;
};

// The detector finds the keypoints of a level in the differences between one Gaussian below the
// level and two above. It subtracts the Gaussians on the fly, because storing the differences costs
// more.
struct ScaleSpaceOctave {
  SiftLevels levels;
  std::vector<FloatImage> gaussians;  // For levels.first - 1 to levels.last + 2.

  // The image blurred by SiftSigmaPx(level).
  const FloatImage& Level(int level) const { return gaussians[level - (levels.first - 1)]; }
};

// `image` has the pixel size of the octave. Its blur is `sigma_px`, in its own pixels, and less
// than SiftSigmaPx(levels.first - 1). Once `should_stop` returns true, the other Gaussians are
// missing.
ScaleSpaceOctave MakeScaleSpaceOctave(const FloatImage& image, double sigma_px,
                                      const SiftLevels& levels = {},
                                      const StopFunction& should_stop = {});

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_SCALE_SPACE_H_
