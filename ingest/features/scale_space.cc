#include "ingest/features/scale_space.h"

#include <cmath>

#include "ingest/features/gaussian_blur.h"

namespace cairn {
namespace {

// What a blur of `from_px` lacks of one of `to_px`.
double SigmaBetween(double from_px, double to_px) {
  return std::sqrt(to_px * to_px - from_px * from_px);
}

}  // namespace

double SiftSigmaPx(double level) {
  return kSiftBaseSigmaPx * std::exp2(level / kSiftLevelsPerOctave);
}

ScaleSpaceOctave MakeScaleSpaceOctave(const FloatImage& image, double sigma_px) {
  ScaleSpaceOctave octave;
  octave[0] = GaussianBlur(image, SigmaBetween(sigma_px, SiftSigmaPx(0)));
  for (size_t i = 1; i < octave.size(); ++i) {
    const auto level = static_cast<double>(i);
    octave[i] =
        GaussianBlur(octave[i - 1], SigmaBetween(SiftSigmaPx(level - 1.0), SiftSigmaPx(level)));
  }
  return octave;
}

}  // namespace cairn
