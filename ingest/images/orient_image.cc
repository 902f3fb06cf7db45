#include "ingest/images/orient_image.h"

#include <utility>

#include "core/check.h"

namespace cairn {

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
