// Locates the real data for tests. Tests skip if the data is absent.
#ifndef CAIRN_TESTS_SUPPORT_TEST_DATA_H_
#define CAIRN_TESTS_SUPPORT_TEST_DATA_H_

#include <cstdlib>
#include <filesystem>
#include <string>

namespace cairn::testing {

// Returns $CAIRN_TEST_DATA or, if unset, ../shared/data beside the source tree.
inline std::filesystem::path TestDataDir() {
  if (const char* dir = std::getenv("CAIRN_TEST_DATA")) {
    return dir;
  }
  return std::filesystem::path(CAIRN_SOURCE_DIR) / ".." / "shared" / "data";
}

}  // namespace cairn::testing

// Skips the running test with a message if a file or folder of the test data is missing.
#define CAIRN_SKIP_WITHOUT_DATA(relative_path)                                                 \
  if (!std::filesystem::exists(::cairn::testing::TestDataDir() / (relative_path)))             \
  GTEST_SKIP() << "test data not found: " << ::cairn::testing::TestDataDir() / (relative_path) \
               << " (set CAIRN_TEST_DATA)"

#endif  // CAIRN_TESTS_SUPPORT_TEST_DATA_H_
