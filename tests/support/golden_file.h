// Access to the files of tests/golden.
#ifndef CAIRN_TESTS_SUPPORT_GOLDEN_FILE_H_
#define CAIRN_TESTS_SUPPORT_GOLDEN_FILE_H_

#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace cairn::testing {

inline std::string GoldenPath(const std::string& name) {
  return std::string(CAIRN_SOURCE_DIR) + "/tests/golden/" + name;
}

// Returns an empty vector if there is no such file.
inline std::vector<uint8_t> GoldenFile(const std::string& name) {
  std::ifstream file(GoldenPath(name), std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_GOLDEN_FILE_H_
