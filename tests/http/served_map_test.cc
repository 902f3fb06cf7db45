// Tests maps whose files are replaced, removed, damaged or copied while they are served.
#include "http/service/served_map.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sqlite3.h>
#include <sys/mount.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "http/server_fixture.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class ServedMapFiles : public ::testing::Test {
 protected:
  ServedMapFiles() { MakeMap(path_, "monday"); }

  static void MakeMap(const std::string& path, const std::string& session) {
    MapStore store = MapStore::Create(path);
    AddSession(session, &store);
  }
  static void AddSession(const std::string& session, MapStore* store) {
    MapUpdate update = store->BeginUpdate();
    SessionRecord record;
    record.name = session;
    update.AddSession(record);
    update.Publish();
  }
  // The new file takes the name at once, as `mv` does it.
  void Replace(const std::string& session) {
    MakeMap(next_path_, session);
    fs::rename(next_path_, path_);
  }
  static void SetCreationTime(const std::string& path, const std::string& time) {
    sqlite3* db = nullptr;
    EXPECT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
    const std::string sql = "UPDATE cairn_map SET created_at = '" + time + "'";
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(db);
  }
  // The bytes of the file change, as `cp` does it.
  void Overwrite(const std::string& from, uintmax_t num_bytes) {
    std::ifstream source(from, std::ios::binary);
    std::string bytes(num_bytes, '\0');
    source.read(bytes.data(), static_cast<std::streamsize>(num_bytes));
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
    // The clock of files has a coarse tick.
    fs::last_write_time(path_, fs::last_write_time(path_) + std::chrono::seconds(++num_written_));
  }
  static std::string Sessions(const ServedMap& map) {
    std::string names;
    for (const SessionRecord& session : map.store().Snapshot().Sessions()) {
      names += session.name + " ";
    }
    return names;
  }
  static void ExpectSound(const ServedMap& map) {
    EXPECT_THAT(map.store().Check({}).problems, ::testing::IsEmpty());
  }

  testing::TempDir dir_;
  const std::string path_ = dir_.File("map.gpkg");
  const std::string next_path_ = dir_.File("next.gpkg");
  int num_written_ = 0;
};

TEST_F(ServedMapFiles, AFileThatTakesTheNameIsServed) {
  ServedMaps maps({.path = path_});
  Replace("tuesday");
  maps.Refresh();
  EXPECT_EQ(Sessions(*maps.Current()), "tuesday ");
  EXPECT_EQ(maps.Problem(), "");
  ExpectSound(*maps.Current());
}

TEST_F(ServedMapFiles, WhoHoldsTheOldMapKeepsItsFile) {
  ServedMaps maps({.path = path_});
  std::shared_ptr<const ServedMap> old = maps.Current();
  std::optional<MapSnapshot> snapshot = old->store().Snapshot();
  Replace("tuesday");
  EXPECT_EQ(old->store().FileState(), MapFileState::kReplaced);
  // No connection to the old file can be made any more: this waits for the snapshot's.
  std::string sessions;
  std::thread other([&] { sessions = Sessions(*old); });
  maps.Refresh();
  EXPECT_EQ(Sessions(*maps.Current()), "tuesday ");
  EXPECT_EQ(snapshot->Sessions().front().name, "monday");
  snapshot.reset();
  other.join();
  EXPECT_EQ(sessions, "monday ");
  ExpectSound(*old);
}

TEST_F(ServedMapFiles, UpdatesOfTheNewMapAreSeenWhenTheOldOneIsLeft) {
  ServedMaps maps({.path = path_});
  std::shared_ptr<const ServedMap> old = maps.Current();
  old->store().Snapshot();  // Makes the log, as queries do.
  Replace("tuesday");
  maps.Refresh();
  maps.Refresh();
  EXPECT_TRUE(maps.Current()->is_stand_in);
  const std::shared_ptr<TileCache> cache = maps.Current()->localizer->cache();
  old.reset();
  maps.Refresh();
  EXPECT_FALSE(maps.Current()->is_stand_in);
  EXPECT_EQ(maps.Current()->localizer->cache(), cache);
  MapStore writer = MapStore::Open(path_, OpenMode::kReadWrite);
  AddSession("wednesday", &writer);
  EXPECT_EQ(Sessions(*maps.Current()), "tuesday wednesday ");
  EXPECT_EQ(maps.Problem(), "");
  ExpectSound(*maps.Current());
}

// SQLite would take the log for that of the new file and read pages of another map from it.
TEST_F(ServedMapFiles, TheLogOfTheOldMapIsNotReadIntoTheNewOne) {
  {
    ServedMaps maps({.path = path_});
    {
      MapStore writer = MapStore::Open(path_, OpenMode::kReadWrite);
      AddSession("tuesday", &writer);
    }
    EXPECT_EQ(Sessions(*maps.Current()), "monday tuesday ");
    ASSERT_GT(fs::file_size(path_ + "-wal"), 0u);
    Replace("wednesday");
    for (int i = 0; i < 3; ++i) {
      maps.Refresh();
      EXPECT_EQ(Sessions(*maps.Current()), "wednesday ");
      ExpectSound(*maps.Current());
    }
    EXPECT_THAT(maps.Problem(), HasSubstr("write-ahead log"));
    fs::remove(path_ + "-wal");
    fs::remove(path_ + "-shm");
    maps.Refresh();
    EXPECT_EQ(maps.Problem(), "");
    EXPECT_FALSE(maps.Current()->is_stand_in);
    EXPECT_EQ(Sessions(*maps.Current()), "wednesday ");
  }
}

TEST_F(ServedMapFiles, AMissingFileIsAProblemAndNotTheEnd) {
  ServedMaps maps({.path = path_});
  fs::rename(path_, next_path_);
  maps.Refresh();
  EXPECT_EQ(maps.Problem(), "the map file is missing");
  EXPECT_EQ(Sessions(*maps.Current()), "monday ");
  maps.Reload();
  EXPECT_EQ(Sessions(*maps.Current()), "monday ");
  fs::rename(next_path_, path_);
  maps.Refresh();
  EXPECT_EQ(maps.Problem(), "");
}

TEST_F(ServedMapFiles, AFileThatIsNoMapIsNotServed) {
  ServedMaps maps({.path = path_});
  std::ofstream(next_path_) << "notes";
  fs::rename(next_path_, path_);
  maps.Refresh();
  EXPECT_THAT(maps.Problem(), HasSubstr("cannot be opened"));
  EXPECT_THAT(maps.Problem(), ::testing::Not(HasSubstr(path_)));
  EXPECT_EQ(Sessions(*maps.Current()), "monday ");
  Replace("tuesday");
  maps.Refresh();
  EXPECT_EQ(maps.Problem(), "");
  EXPECT_EQ(Sessions(*maps.Current()), "tuesday ");
}

TEST_F(ServedMapFiles, AMapThatIsCutOffIsNotServed) {
  ServedMaps maps({.path = path_});
  MakeMap(next_path_, "tuesday");
  const auto num_bytes = fs::file_size(next_path_);
  constexpr uintmax_t kPageBytes = 16384;
  fs::resize_file(next_path_, num_bytes / kPageBytes / 2 * kPageBytes);  // Whole pages.
  fs::rename(next_path_, path_);
  maps.Refresh();
  EXPECT_THAT(maps.Problem(), HasSubstr("cannot be opened"));
  EXPECT_EQ(Sessions(*maps.Current()), "monday ");
}

TEST_F(ServedMapFiles, ReloadKeepsTheTilesOfAMapThatIsTheSame) {
  ServedMaps maps({.path = path_});
  const std::shared_ptr<const ServedMap> before = maps.Current();
  maps.Reload();
  EXPECT_EQ(maps.Current(), before);
  MapStore writer = MapStore::Open(path_, OpenMode::kReadWrite);
  AddSession("tuesday", &writer);
  maps.Reload();
  EXPECT_EQ(maps.Current(), before);
}

TEST_F(ServedMapFiles, AMapThatIsCopiedOverTheFileIsServedWhenItIsComplete) {
  ServedMaps maps({.path = path_});
  MakeMap(next_path_, "tuesday");
  SetCreationTime(next_path_, "2026-11-24T00:00:00Z");  // Both maps are made in one second.
  const auto num_bytes = fs::file_size(next_path_);
  EXPECT_EQ(Sessions(*maps.Current()), "monday ");
  Overwrite(next_path_, num_bytes / 2);
  maps.Refresh();
  EXPECT_THAT(maps.Problem(), HasSubstr("cannot be opened"));
  Overwrite(next_path_, num_bytes);
  maps.Refresh();
  EXPECT_THAT(maps.Problem(), HasSubstr("overwritten"));
  maps.Refresh();
  EXPECT_EQ(maps.Problem(), "");
  EXPECT_EQ(Sessions(*maps.Current()), "tuesday ");
  ExpectSound(*maps.Current());
}

TEST_F(ServedMapFiles, ANewerCopyOverTheFileIsServed) {
  fs::copy_file(path_, next_path_);
  {
    MapStore writer = MapStore::Open(next_path_, OpenMode::kReadWrite);
    AddSession("tuesday", &writer);
  }
  ServedMaps maps({.path = path_});
  EXPECT_EQ(Sessions(*maps.Current()), "monday ");
  Overwrite(next_path_, fs::file_size(next_path_));
  maps.Refresh();
  maps.Refresh();
  EXPECT_EQ(maps.Problem(), "");
  EXPECT_EQ(Sessions(*maps.Current()), "monday tuesday ");
  ExpectSound(*maps.Current());
}

TEST_F(ServedMapFiles, UpdatesInTheFileAreNoOtherMap) {
  ServedMaps maps({.path = path_});
  const std::shared_ptr<const ServedMap> before = maps.Current();
  {
    MapStore writer = MapStore::Open(path_, OpenMode::kReadWrite);
    AddSession("tuesday", &writer);
  }
  fs::last_write_time(path_, fs::last_write_time(path_) + std::chrono::seconds(1));
  maps.Refresh();
  EXPECT_EQ(maps.Problem(), "");
  maps.Refresh();
  EXPECT_EQ(maps.Current(), before);
  EXPECT_EQ(Sessions(*maps.Current()), "monday tuesday ");
}

// A writer in another process that found the file unlocked would delete the log.
TEST_F(ServedMapFiles, AFileThatWasOpenedAgainStaysLocked) {
  ServedMaps maps({.path = path_});
  fs::last_write_time(path_, fs::last_write_time(path_) + std::chrono::seconds(1));
  maps.Refresh();
  constexpr off_t kSharedLock = 0x40000000 + 2;  // SHARED_FIRST of SQLite.
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = kSharedLock;
  lock.l_len = 510;
  const int fd = open(path_.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(fcntl(fd, F_OFD_GETLK, &lock), 0);
  EXPECT_EQ(lock.l_type, F_RDLCK);
  close(fd);
}

TEST_F(ServedMapFiles, TagsTellTilesOfCopiesApart) {
  ServedMaps maps({.path = path_});
  const std::shared_ptr<const ServedMap> map = maps.Current();
  TileRecord tile;
  tile.payload_id = PayloadId(7);
  tile.num_bytes = 1000;
  TileRecord other = tile;  // The same id in a copy that went its own way.
  other.num_bytes = 1001;
  EXPECT_EQ(map->TileTag(tile), map->TileTag(tile));
  EXPECT_NE(map->TileTag(tile), map->TileTag(other));
  other = tile;
  other.landmark_bounds.north_rad += 1e-12;
  EXPECT_NE(map->TileTag(tile), map->TileTag(other));
}

class ServerOfReplacedMaps : public testing::ServerFixture {};

TEST_F(ServerOfReplacedMaps, QueriesAreAnsweredFromOneMapOrTheOther) {
  std::atomic<bool> done{false};
  std::atomic<int> num_localized{0};
  std::vector<std::thread> askers;
  for (int i = 0; i < 3; ++i) {
    askers.emplace_back([&] {
      LocalizeClient client = Client();
      while (!done) {
        num_localized += client.LocalizeFeatures(Query()).localized;
      }
    });
  }
  const std::string next = dir_->File("next.gpkg");
  for (int i = 0; i < 4; ++i) {
    const int num_before = num_localized;
    while (num_localized < num_before + 6) {
      std::this_thread::yield();
    }
    fs::copy_file(map_path(), next);
    fs::rename(next, map_path());
    server_->ReloadMap();
  }
  done = true;
  for (std::thread& asker : askers) {
    asker.join();
  }
  EXPECT_GE(num_localized, 24);
}

// A map that is mounted without its folder, as container engines do with a single file.
class MountedMap : public ServedMapFiles {
 protected:
  void SetUp() override {
    std::ofstream(mounted_path_).put('\n');
    if (unshare(CLONE_NEWNS) != 0 ||
        mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount(path_.c_str(), mounted_path_.c_str(), nullptr, MS_BIND, nullptr) != 0) {
      GTEST_SKIP() << "this process may not mount files: " << std::strerror(errno);
    }
  }
  void TearDown() override { umount2(mounted_path_.c_str(), MNT_DETACH); }

  const std::string mounted_path_ = dir_.File("mounted.gpkg");
};

TEST_F(MountedMap, ServerSaysThatUpdatesMayBeInvisible) {
  ServedMaps maps({.path = mounted_path_});
  EXPECT_THAT(maps.Problem(), HasSubstr("without its folder"));
  maps.Refresh();
  EXPECT_THAT(maps.Problem(), HasSubstr("without its folder"));
}

TEST_F(MountedMap, WhatWritersPutIntoTheFileIsServed) {
  ServedMaps maps({.path = mounted_path_});
  EXPECT_EQ(Sessions(*maps.Current()), "monday ");
  {
    MapStore writer = MapStore::Open(path_, OpenMode::kReadWrite);
    AddSession("tuesday", &writer);
  }
  // The clock of files has a coarse tick.
  fs::last_write_time(path_, fs::last_write_time(path_) + std::chrono::seconds(1));
  maps.Refresh();
  EXPECT_EQ(Sessions(*maps.Current()), "monday tuesday ");
  ExpectSound(*maps.Current());
}

}  // namespace
}  // namespace cairn
