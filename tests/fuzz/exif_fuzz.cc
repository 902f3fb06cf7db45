// EXIF data of photos.
#include "core/error.h"
#include "core/images/exif.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const cairn::ExifInfo exif = cairn::ReadExif({data, size});
    CAIRN_CHECK(exif.orientation >= 1 && exif.orientation <= 8, "EXIF knows orientations 1 to 8");
  } catch (const cairn::Error& error) {
    CAIRN_CHECK(error.code() == cairn::ErrorCode::kBadInput, error.what());
  }
  return 0;
}
