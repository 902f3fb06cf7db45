// Binary PGM and PPM, magic numbers P5 and P6 (https://netpbm.sourceforge.net/doc/pgm.html).
#ifndef CAIRN_CORE_IMAGES_PNM_DECODER_H_
#define CAIRN_CORE_IMAGES_PNM_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/images/gray_image.h"

namespace cairn {

struct PnmHeader {
  int64_t width_px = 0;
  int64_t height_px = 0;
  int max_value = 0;          // Largest sample; above 255, a sample has two bytes.
  int samples_per_pixel = 0;  // 1: gray, 3: red, green, blue.
  size_t pixels_at = 0;       // Offset of the first sample. All samples are present.
};

// `bytes` begin with P5 or P6. A comment extends from '#' to the end of its line (line feed or
// carriage return) and may occur anywhere before the pixels. Throws Error(kBadInput) if the header
// is invalid or pixels are missing.
PnmHeader ParsePnmHeader(std::span<const uint8_t> bytes);

// Decodes the first image of the file and scales samples to 255. Calls `limits.should_stop` between
// rows. Throws as ParsePnmHeader. Throws DecodingStopped.
GrayImage DecodePnm(std::span<const uint8_t> bytes, const ImageDecodeLimits& limits);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_PNM_DECODER_H_
