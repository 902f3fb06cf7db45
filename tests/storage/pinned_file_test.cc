// Tests files that are renamed or removed while they are in use.
#include "storage/map/pinned_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include "core/error.h"
#include "storage/database/sqlite/connection.h"
#include "storage/database/sqlite/transaction.h"
#include "storage/map/map_store.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

TEST(PinnedFile, FollowsTheFileAndNotTheName) {
  const testing::TempDir dir;
  EXPECT_FALSE(PinnedFile(dir.File("a")).IsAt(dir.File("a")));
  std::ofstream(dir.File("a")) << "a";
  const PinnedFile pinned(dir.File("a"));
  EXPECT_TRUE(pinned.IsAt(dir.File("a")));
  fs::rename(dir.File("a"), dir.File("b"));
  EXPECT_FALSE(pinned.IsAt(dir.File("a")));
  EXPECT_TRUE(pinned.IsAt(dir.File("b")));
  // The number of a removed file is not given to the next one.
  fs::remove(dir.File("b"));
  std::ofstream(dir.File("a")) << "a";
  EXPECT_FALSE(pinned.IsAt(dir.File("a")));
}

TEST(MapStore, StaysWithItsFileWhenAnotherTakesTheName) {
  const testing::TempDir dir;
  const std::string path = dir.File("map.gpkg");
  MapStore::Create(path).BeginUpdate().Publish();
  const MapStore store = MapStore::Open(path, OpenMode::kReadOnly);
  EXPECT_EQ(store.FileState(), MapFileState::kInPlace);
  std::optional<MapSnapshot> first = store.Snapshot();
  MapStore::Create(dir.File("next.gpkg"));
  fs::rename(dir.File("next.gpkg"), path);
  EXPECT_EQ(store.FileState(), MapFileState::kReplaced);
  // A new connection would be to the other file.
  std::optional<MapVersion> version;
  std::thread other([&] { version = store.Snapshot().version(); });
  EXPECT_EQ(first->version(), MapVersion(2));
  first.reset();
  other.join();
  EXPECT_EQ(version, MapVersion(2));
  fs::remove(path);
  EXPECT_EQ(store.FileState(), MapFileState::kMissing);
  EXPECT_EQ(store.Snapshot().version(), MapVersion(2));
}

TEST(MapStore, AnImmutableOneReadsTheFileWithoutTheLogBesideIt) {
  const testing::TempDir dir;
  const std::string path = dir.File("map.gpkg");
  MapStore writer = MapStore::Create(path);
  // A reader keeps the log from being taken into the file.
  sqlite::Connection reader(path, sqlite::Access::kReadOnly, 0);
  const sqlite::Transaction reading(&reader, sqlite::Transaction::Kind::kDeferred);
  reader.Execute("SELECT * FROM cairn_versions");
  writer.BeginUpdate().Publish();
  ASSERT_GT(fs::file_size(writer.LogPath()), 0u);
  EXPECT_EQ(MapStore::Open(path, OpenMode::kReadOnly).Snapshot().version(), MapVersion(2));
  MapStore immutable = MapStore::Open(path, OpenMode::kImmutable);
  EXPECT_EQ(immutable.Snapshot().version(), MapVersion(1));
  EXPECT_THROW(immutable.BeginUpdate(), Error);
}

}  // namespace
}  // namespace cairn
