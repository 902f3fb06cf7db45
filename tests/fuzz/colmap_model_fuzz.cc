// COLMAP's models, binary and text. The first byte selects which of the six files the remaining
// bytes are. The other two files of that kind are a small valid model.
#include <array>
#include <string>
#include <string_view>

#include "core/error.h"
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_target.h"
#include "ingest/colmap/colmap_model.h"

namespace cairn {
namespace {

struct ModelFile {
  const char* name;
  std::string_view valid;
};

using namespace std::string_view_literals;

constexpr std::array<ModelFile, 3> kTextFiles = {{
    {"cameras.txt", "1 PINHOLE 640 480 500 500 320 240\n"},
    {"images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n10 20 1\n"},
    {"points3D.txt", "1 0 0 5 0 0 0 0.5 1 0\n"},
}};

// No cameras, images or points: eight bytes of count.
constexpr std::array<ModelFile, 3> kBinaryFiles = {{
    {"cameras.bin", "\0\0\0\0\0\0\0\0"sv},
    {"images.bin", "\0\0\0\0\0\0\0\0"sv},
    {"points3D.bin", "\0\0\0\0\0\0\0\0"sv},
}};

void WriteModel(const std::array<ModelFile, 3>& files, size_t fuzzed, std::string_view bytes) {
  for (size_t i = 0; i < files.size(); ++i) {
    cairn::testing::WriteFuzzFile(files[i].name, i == fuzzed ? bytes : files[i].valid);
  }
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  if (size == 0) {
    return 0;
  }
  const size_t which = data[0] % 6;
  const bool is_text = which < 3;
  WriteModel(is_text ? kTextFiles : kBinaryFiles, which % 3,
             cairn::testing::AsText(data + 1, size - 1));
  const std::string folder = cairn::testing::FuzzFolder().path().string();
  try {
    const ColmapModel model = is_text ? ReadTextColmapModel(folder) : ReadBinaryColmapModel(folder);
    for (const ColmapPoint& point : model.points) {
      CAIRN_CHECK(point.x_in_world.allFinite(), "a point that is not finite");
    }
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput, error.what());
  }
  return 0;
}
