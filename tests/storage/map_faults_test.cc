// What updates leave when their process dies, the disk is full, or the file is copied meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "storage/map/extract_map.h"
#include "storage/map/map_history.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile_codec.h"
#include "support/faulty_disk.h"
#include "support/map_builder.h"
#include "support/places.h"
#include "support/temp_dir.h"
#include "support/whole_versions.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using testing::MapOperation;
using testing::PutPlace;
using testing::RemovePlace;

constexpr char kMap[] = "map.gpkg";

MapStore OpenForWriting(const fs::path& folder) {
  return MapStore::Open((folder / kMap).string(), OpenMode::kReadWrite);
}

// Four versions with content; place 0 was replaced, place 2 is gone.
void PrepareFourVersions(const fs::path& folder) {
  MapStore store = MapStore::Create((folder / kMap).string());
  for (int step = 0; step < 4; ++step) {
    MapUpdate update = store.BeginUpdate();
    PutPlace(step % 3, step, &update, 200);
    if (step == 3) {
      RemovePlace(2, &update);
    }
    update.Publish();
  }
}

struct NamedOperation {
  const char* name;
  MapOperation operation;
};

const NamedOperation kOperations[] = {
    {"Update",
     {{kMap},
      PrepareFourVersions,
      [](const fs::path& folder) {
        MapStore store = OpenForWriting(folder);
        MapUpdate update = store.BeginUpdate();
        PutPlace(0, 7, &update, 200);
        PutPlace(3, 8, &update, 200);
        RemovePlace(1, &update);
        update.Publish();
      }}},
    {"RollBack",
     {{kMap},
      PrepareFourVersions,
      [](const fs::path& folder) {
        MapStore store = OpenForWriting(folder);
        RollBack(MapVersion(4), &store);
      }}},
    {"Prune",
     {{kMap},
      PrepareFourVersions,
      [](const fs::path& folder) {
        MapStore store = OpenForWriting(folder);
        Prune({.keep = 1}, &store);
      }}},
    {"Extract",
     {{kMap, "part.gpkg"},
      PrepareFourVersions,
      [](const fs::path& folder) {
        const MapStore store = OpenForWriting(folder);
        ExtractMap(store, GeoRegion::OfBox(49.0, 8.4, 49.1, 8.5), (folder / "part.gpkg").string());
      }}},
    {"Compact",
     {{kMap},
      [](const fs::path& folder) {
        PrepareFourVersions(folder);
        MapStore store = OpenForWriting(folder);
        Prune({.keep = 1}, &store);
      },
      [](const fs::path& folder) {
        MapStore store = OpenForWriting(folder);
        CompactMap(&store);
      }}},
};

class MapFaults : public ::testing::TestWithParam<NamedOperation> {};

TEST_P(MapFaults, KillsLeaveWholeVersions) {
  testing::ExpectWholeVersionsAfterKills(GetParam().operation, 34);
}

TEST_P(MapFaults, FullDisksLeaveWholeVersions) {
  testing::ExpectWholeVersionsOnFullDisks(GetParam().operation, 8);
}

TEST_P(MapFaults, CopiesHoldWholeVersions) {
  testing::ExpectWholeVersionsInCopies(GetParam().operation, 8);
}

INSTANTIATE_TEST_SUITE_P(Operations, MapFaults, ::testing::ValuesIn(kOperations),
                         [](const auto& test) { return std::string(test.param.name); });

void ExpectWhole(const MapSnapshot& snapshot) {
  const MapInfo info = snapshot.Info();
  EXPECT_EQ(info.version, snapshot.version());
  int64_t num_landmarks = 0;
  for (const TileRecord& tile : snapshot.AllTiles(10)) {
    num_landmarks +=
        static_cast<int64_t>(DecodeTile(snapshot.LoadPayload(tile.payload_id)).num_landmarks());
  }
  EXPECT_EQ(num_landmarks, info.num_landmarks);
  EXPECT_EQ(std::ssize(snapshot.Sessions()), info.num_sessions);
}

// Reads a version, which may be pruned meanwhile.
void ReadWholeVersion(const MapStore& store) {
  try {
    ExpectWhole(store.Snapshot());
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnavailable) << error.what();
  }
}

// Runs `update` while threads read again and again. Each reads once more when it has ended.
void UpdateBesideReaders(int num_readers, const std::function<void()>& read,
                         const std::function<void()>& update) {
  std::atomic<bool> is_done = false;
  std::vector<std::thread> readers;
  for (int i = 0; i < num_readers; ++i) {
    readers.emplace_back([&] {
      bool is_last = false;
      while (!is_last) {
        is_last = is_done;
        read();
      }
    });
  }
  EXPECT_NO_THROW(update());  // An exception that passed the readers would hide its message.
  is_done = true;
  for (std::thread& reader : readers) {
    reader.join();
  }
}

// A reader that finds the head of the log half written takes the write lock for a moment.
TEST(MapReaders, StopNoUpdate) {
  const testing::TempDir dir;
  PrepareFourVersions(dir.path());
  MapStore store = OpenForWriting(dir.path());
  UpdateBesideReaders(
      8, [&] { (void)store.Snapshot(); },
      [&] {
        for (int round = 0; round < 200; ++round) {
          store.ReserveIds({.num_landmarks = 1});
        }
      });
}

TEST(MapReaders, SeeWholeVersionsWhateverIsDone) {
  const testing::TempDir dir;
  PrepareFourVersions(dir.path());
  MapStore store = OpenForWriting(dir.path());
  UpdateBesideReaders(
      20, [&] { ReadWholeVersion(store); },
      [&] {
        for (int round = 0; round < 4; ++round) {
          MapUpdate update = store.BeginUpdate();
          PutPlace(round % 2, 10 + round, &update, 30 + round);
          const MapVersion version = update.Publish();
          RollBack(MapVersion(Value(version) - 1), &store);
          Prune({.keep = 3}, &store);
          CompactMap(&store);
        }
      });
  EXPECT_THAT(store.Check({}).problems, ::testing::IsEmpty());
}

}  // namespace
}  // namespace cairn
