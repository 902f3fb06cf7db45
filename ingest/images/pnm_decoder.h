// Binary PGM and PPM, magic numbers P5 and P6 (https://netpbm.sourceforge.net/doc/pgm.html).
#ifndef CAIRN_INGEST_IMAGES_PNM_DECODER_H_
#define CAIRN_INGEST_IMAGES_PNM_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "ingest/images/gray_image.h"

namespace cairn {

struct PnmHeader {
  int64_t width_px = 0;
  int64_t height_px = 0;
  int max_value = 0;          // Of a sample; above 255 a sample has two bytes.
  int samples_per_pixel = 0;  // 1: grey, 3: red, green, blue.
  size_t pixels_at = 0;       // Where the first sample stands. All are there.
};

// `bytes` begin with P5 or P6. A comment runs from '#' to the end of its line, a line feed or
// carriage return, and may stand anywhere before the pixels. Throws Error(kBadInput) if the header
// is none or the pixels end early.
PnmHeader ParsePnmHeader(std::span<const uint8_t> bytes);

// Decodes the first image of the file; samples are scaled to 255. Asks `limits.should_stop` between
// rows. Throws as ParsePnmHeader, and DecodingStopped.
GrayImage DecodePnm(std::span<const uint8_t> bytes, const ImageDecodeLimits& limits);

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_PNM_DECODER_H_
