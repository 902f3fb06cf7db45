// Tests folders of processes that live and that died.
#include "ingest/temporary_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "support/temp_dir.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

class TemporaryFolders : public ::testing::Test {
 protected:
  TemporaryFolders() { setenv("TMPDIR", dir_.path().c_str(), 1); }
  ~TemporaryFolders() override {
    if (before_) {
      setenv("TMPDIR", before_->c_str(), 1);
    } else {
      unsetenv("TMPDIR");
    }
  }

  size_t NumFolders() const {
    const auto size = std::distance(fs::directory_iterator(dir_.path()), fs::directory_iterator());
    return static_cast<size_t>(size);
  }
  static std::optional<std::string> Environment() {
    const char* value = getenv("TMPDIR");
    return value == nullptr ? std::nullopt : std::optional<std::string>(value);
  }

  const std::optional<std::string> before_ = Environment();
  const testing::TempDir dir_;
};

TEST_F(TemporaryFolders, GoWithTheObject) {
  {
    const TemporaryFolder folder;
    std::ofstream(folder.path() + "/file") << "content";
    EXPECT_EQ(NumFolders(), 1u);
  }
  EXPECT_EQ(NumFolders(), 0u);
}

TEST_F(TemporaryFolders, OfTheDeadGoWithTheNextAndThoseOfTheLivingStay) {
  const TemporaryFolder living;
  const pid_t child = fork();
  if (child == 0) {
    const TemporaryFolder dead;
    std::ofstream(dead.path() + "/file") << "content";
    _exit(0);  // Without destructors, as if killed.
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_EQ(NumFolders(), 2u);
  fs::create_directory(dir_.File("cairn-other"));
  const TemporaryFolder next;
  EXPECT_EQ(NumFolders(), 3u);
  EXPECT_TRUE(fs::exists(living.path()));
  EXPECT_TRUE(fs::exists(dir_.File("cairn-other")));
}

}  // namespace
}  // namespace cairn
