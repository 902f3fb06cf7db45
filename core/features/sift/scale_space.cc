#include "core/features/sift/scale_space.h"

#include <cmath>

#include "core/features/sift/gaussian_blur.h"

namespace cairn {
namespace {

// The blur that turns a blur of `from_px` into a blur of `to_px`.
double SigmaBetween(double from_px, double to_px) {
  return std::sqrt(to_px * to_px - from_px * from_px);
}

}  // namespace

double SiftSigmaPx(double level) {
  return kSiftBaseSigmaPx * std::exp2(level / kSiftLevelsPerOctave);
}

ScaleSpaceOctave MakeScaleSpaceOctave(const FloatImage& image, double sigma_px,
                                      const SiftLevels& levels, const StopFunction& should_stop) {
  ScaleSpaceOctave octave{.levels = levels, .gaussians = {}};
  const int lowest = levels.first - 1;
  octave.gaussians.push_back(GaussianBlur(image, SigmaBetween(sigma_px, SiftSigmaPx(lowest))));
  for (int level = lowest + 1; level <= levels.last + 2; ++level) {
    if (should_stop && should_stop()) {
      break;
    }
    octave.gaussians.push_back(GaussianBlur(
        octave.Level(level - 1), SigmaBetween(SiftSigmaPx(level - 1), SiftSigmaPx(level))));
  }
  return octave;
}

}  // namespace cairn
