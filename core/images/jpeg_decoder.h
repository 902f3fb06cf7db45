// Decodes JPEG to gray (by libjpeg-turbo).
#ifndef CAIRN_CORE_IMAGES_JPEG_DECODER_H_
#define CAIRN_CORE_IMAGES_JPEG_DECODER_H_

#include <cstdint>
#include <span>

#include "core/images/gray_image.h"
#include "core/images/image_header.h"

namespace cairn {

// Decodes a JPEG of one or three components. `header` states its size. Gray is the luma component,
// so color costs nothing. An image of more than `limits.max_pixels` is decoded at the largest scale
// n/8 that has no more, by a smaller inverse DCT, and the result has `full`. Besides the result,
// memory holds a few rows of blocks; of an image in several scans, such as a progressive one, all
// coefficients, which may take 24 bytes for each of `limits.max_pixels`. Calls `limits.should_stop`
// after every row of blocks. Throws Error(kBadInput) if the image has four components (CMYK), lacks
// pixels, is damaged in more than a few places, has more coefficients, or has more than 100 scans
// (an honest progressive image has about 10). An image without end marker is decoded if no pixel
// is missing. Throws DecodingStopped.
GrayImage DecodeJpeg(std::span<const uint8_t> bytes, const ImageHeader& header,
                     const ImageDecodeLimits& limits);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_JPEG_DECODER_H_
