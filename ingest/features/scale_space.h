// An octave of the scale space of SIFT (Lowe 2004): an image at growing blur.
#ifndef CAIRN_INGEST_FEATURES_SCALE_SPACE_H_
#define CAIRN_INGEST_FEATURES_SCALE_SPACE_H_

#include <array>

#include "ingest/features/float_image.h"

namespace cairn {

inline constexpr int kSiftLevelsPerOctave = 3;
inline constexpr double kSiftBaseSigmaPx = 1.6;
// Of a sharp image, in its own pixels, as Lowe and COLMAP assume it.
inline constexpr double kSharpSigmaPx = 0.5;

// The blur of a level, which may lie between two, in pixels of its octave.
double SiftSigmaPx(double level);

// Blurred by SiftSigmaPx(0), SiftSigmaPx(1), ... . The differences of neighbours, in which
// keypoints are found, are subtracted where they are needed: writing them costs more.
using ScaleSpaceOctave = std::array<FloatImage, kSiftLevelsPerOctave + 3>;

// `image` has pixels of the octave's size and a blur of `sigma_px` of them, less than
// kSiftBaseSigmaPx.
ScaleSpaceOctave MakeScaleSpaceOctave(const FloatImage& image, double sigma_px);

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SCALE_SPACE_H_
