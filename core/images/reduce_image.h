// Reduces images by averaging areas.
#ifndef CAIRN_CORE_IMAGES_REDUCE_IMAGE_H_
#define CAIRN_CORE_IMAGES_REDUCE_IMAGE_H_

#include <cstdint>

#include "core/images/gray_image.h"

namespace cairn {

// Returns the largest image with at most `max_pixels` pixels (at least 1) and, within a pixel, the
// aspect ratio of `image`. `image` has more pixels than that. A result pixel is the mean of the
// area that it covers.
GrayImage ReduceByArea(const GrayImage& image, int64_t max_pixels);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_REDUCE_IMAGE_H_
