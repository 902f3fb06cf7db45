// Decodes PNG to gray (by libpng).
#ifndef CAIRN_CORE_IMAGES_PNG_DECODER_H_
#define CAIRN_CORE_IMAGES_PNG_DECODER_H_

#include <cstdint>
#include <span>

#include "core/images/gray_image.h"
#include "core/images/image_header.h"

namespace cairn {

// Decodes a PNG; `header` states its size. Colors are weighted as in ITU-R BT.601, and transparency
// is ignored. Chunks that are not needed for pixels are not decompressed. Calls
// `limits.should_stop` between rows, and between the pieces of a file that it reads. Throws
// Error(kBadInput) if the image is damaged. Throws DecodingStopped.
GrayImage DecodePng(std::span<const uint8_t> bytes, const ImageHeader& header,
                    const ImageDecodeLimits& limits);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_PNG_DECODER_H_
