// Blurs an image by a Gaussian, in one pass over its rows.
#ifndef CAIRN_INGEST_FEATURES_GAUSSIAN_BLUR_H_
#define CAIRN_INGEST_FEATURES_GAUSSIAN_BLUR_H_

#include "ingest/features/float_image.h"

namespace cairn {

// The widest Gaussian, whose samples reach 10 pixels to either side.
inline constexpr double kMaxBlurSigmaPx = 10.0 / 3.0;

// The Gaussian of `sigma_px`, in (0, kMaxBlurSigmaPx], is cut off at three sigmas or beyond; what
// lies outside the image is its nearest pixel.
FloatImage GaussianBlur(const FloatImage& image, double sigma_px);

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_GAUSSIAN_BLUR_H_
