// Images of every format, with their EXIF data.
#include "core/error.h"
#include "core/images/exif.h"
#include "core/images/gray_image.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr int64_t kMaxPixels = 100'000;
  try {
    cairn::ReadExif({data, size});
  } catch (const cairn::Error&) {
  }
  try {
    const cairn::GrayImage image = cairn::DecodeGrayImage({data, size}, {.max_pixels = kMaxPixels});
    CAIRN_CHECK(int64_t{image.width_px} * image.height_px <= kMaxPixels, "pixels beyond the limit");
    CAIRN_CHECK(image.pixels.size() == static_cast<size_t>(image.width_px) * image.height_px,
                "pixels and size disagree");
  } catch (const cairn::Error&) {
  }
  return 0;
}
