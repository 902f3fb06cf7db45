// Decodes JPEG to gray (by libjpeg-turbo).
#ifndef CAIRN_INGEST_IMAGES_JPEG_DECODER_H_
#define CAIRN_INGEST_IMAGES_JPEG_DECODER_H_

#include <cstdint>
#include <span>

#include "ingest/images/gray_image.h"
#include "ingest/images/image_header.h"

namespace cairn {

// Decodes a JPEG of one or three components. `header` states its size. Gray is the luma component,
// so color costs nothing. Calls `limits.should_stop` after every row of blocks. Throws
// Error(kBadInput) if the image has four components (CMYK), is damaged in more than a few places,
// or has more than 100 scans (an honest progressive image has about 10). Throws DecodingStopped.
GrayImage DecodeJpeg(std::span<const uint8_t> bytes, const ImageHeader& header,
                     const ImageDecodeLimits& limits);

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_JPEG_DECODER_H_
