#include "core/shared_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

TEST(SharedFolder, LinksAreRefused) {
  const testing::TempDir dir;
  const std::string file = dir.File("file"), folder = dir.File("folder");
  std::ofstream(file) << "text";
  fs::create_directory(folder);
  RequireUnlinkedFile(file);
  RequireUnlinkedFolder(folder);
  RequireUnlinkedFile(dir.File("missing"));
  RequireUnlinkedFolder(dir.File("missing"));
  EXPECT_THROW(RequireUnlinkedFile(folder), Error);
  EXPECT_THROW(RequireUnlinkedFolder(file), Error);
  fs::create_symlink(file, dir.File("file_link"));
  fs::create_symlink(folder, dir.File("folder_link"));
  fs::create_symlink(dir.File("missing"), dir.File("dangling"));
  EXPECT_THROW(RequireUnlinkedFile(dir.File("file_link")), Error);
  EXPECT_THROW(RequireUnlinkedFile(dir.File("dangling")), Error);
  EXPECT_THROW(RequireUnlinkedFolder(dir.File("folder_link")), Error);
  EXPECT_THROW(RequireUnlinkedFolder(dir.File("dangling")), Error);
}

}  // namespace
}  // namespace cairn
