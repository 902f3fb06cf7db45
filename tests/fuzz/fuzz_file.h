// A file that a fuzz target rewrites for each input, for decoders that read files by name.
#ifndef CAIRN_TESTS_FUZZ_FUZZ_FILE_H_
#define CAIRN_TESTS_FUZZ_FUZZ_FILE_H_

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <ios>
#include <string>
#include <string_view>

#include "support/temp_dir.h"

namespace cairn::testing {

// A folder of this process, removed when the process ends.
inline const TempDir& FuzzFolder() {
  static const TempDir folder;
  return folder;
}

// Writes `bytes` to the file `name` and returns its path.
inline std::string WriteFuzzFile(const std::string& name, std::string_view bytes) {
  const std::string path = FuzzFolder().File(name);
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_FUZZ_FUZZ_FILE_H_
