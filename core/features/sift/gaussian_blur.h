// Blurs an image with a Gaussian in one pass over its rows.
#ifndef CAIRN_CORE_FEATURES_SIFT_GAUSSIAN_BLUR_H_
#define CAIRN_CORE_FEATURES_SIFT_GAUSSIAN_BLUR_H_

#include "core/features/sift/float_image.h"

namespace cairn {

// The widest Gaussian. Its kernel reaches 10 pixels to either side.
inline constexpr double kMaxBlurSigmaPx = 10.0 / 3.0;

// `sigma_px` is in (0, kMaxBlurSigmaPx]. The Gaussian is truncated at three sigmas or more. Outside
// the image, the nearest pixel of the image counts.
FloatImage GaussianBlur(const FloatImage& image, double sigma_px);

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_GAUSSIAN_BLUR_H_
