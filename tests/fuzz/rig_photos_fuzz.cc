// Files for `cairn localize --rig`. Beside the file lies the photo a.pgm of 4 x 3 pixels.
#include <cmath>

#include "cli/rig_photos.h"
#include "core/error.h"
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  static const std::string photo =
      cairn::testing::WriteFuzzFile("a.pgm", "P5\n4 3\n255\n123456789abc");
  const std::string path =
      cairn::testing::WriteFuzzFile("rig.json", cairn::testing::AsText(data, size));
  try {
    for (const RigPhoto& taken : ReadRigPhotos(path)) {
      CAIRN_CHECK(taken.camera.cam_from_first.translation.allFinite(), "a camera that is nowhere");
      CAIRN_CHECK(std::abs(taken.camera.cam_from_first.rotation.norm() - 1.0) < 1e-6,
                  "a rotation that is not unit");
    }
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput || error.code() == ErrorCode::kNotFound ||
                    error.code() == ErrorCode::kIo,
                error.what());
  }
  return 0;
}
