#include "eval/pictures/encode_png.h"

#include "core/images/encode_image.h"

namespace cairn {

std::vector<uint8_t> EncodePng(const GrayImage& image) {
  return EncodePng(PictureRows{.width_px = image.width_px,
                               .height_px = image.height_px,
                               .pixels = image.pixels.data(),
                               .row_bytes = static_cast<size_t>(image.width_px)});
}

}  // namespace cairn
