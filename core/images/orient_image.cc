#include "core/images/orient_image.h"

#include <utility>

#include "core/check.h"

namespace cairn {
namespace {

// The place of the turned image in the turned picture. `flips_x` and `flips_y` refer to the axes of
// the stored picture.
FullPicture OrientFull(const GrayImage& stored, bool swaps, bool flips_x, bool flips_y) {
  FullPicture full = *stored.full;
  if (flips_x) {
    full.left_px = full.width_px - (full.left_px + stored.width_px * full.pixel_px);
  }
  if (flips_y) {
    full.top_px = full.height_px - (full.top_px + stored.height_px * full.pixel_px);
  }
  if (swaps) {
    std::swap(full.width_px, full.height_px);
    std::swap(full.left_px, full.top_px);
  }
  return full;
}

}  // namespace

GrayImage OrientImage(GrayImage stored, int orientation) {
  CAIRN_CHECK(orientation >= 1 && orientation <= 8, "EXIF has eight orientations");
  if (orientation == 1) {
    return stored;
  }
  const int width = stored.width_px, height = stored.height_px;
  const bool swaps = SwapsSides(orientation);
  const bool flips_x = orientation == 2 || orientation == 3 || orientation >= 7;
  const bool flips_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  GrayImage upright{.width_px = swaps ? height : width,
                    .height_px = swaps ? width : height,
                    .pixels = std::vector<uint8_t>(stored.pixels.size())};
  if (stored.full) {
    upright.full = OrientFull(stored, swaps, flips_x, flips_y);
  }
  size_t next = 0;
  for (int y = 0; y < upright.height_px; ++y) {
    for (int x = 0; x < upright.width_px; ++x) {
      const int along_x = swaps ? y : x, along_y = swaps ? x : y;
      const int from_x = flips_x ? width - 1 - along_x : along_x;
      const int from_y = flips_y ? height - 1 - along_y : along_y;
      upright.pixels[next++] = stored.pixels[static_cast<size_t>(from_y) * width + from_x];
    }
  }
  return upright;
}

}  // namespace cairn
