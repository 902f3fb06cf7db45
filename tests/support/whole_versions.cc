#include "support/whole_versions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "storage/map/map_store.h"
#include "support/faulty_disk.h"
#include "support/places.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

// All versions and the content of the latest, without times; empty if there is no map.
using MapState = std::vector<std::string>;

MapState StateOf(const fs::path& map) {
  if (!fs::exists(map)) {
    return {};
  }
  return RowsOf(map.string(),
                "SELECT version, kind, session, num_tiles, num_landmarks, payload_bytes "
                "FROM cairn_versions ORDER BY version;"
                "SELECT tile, digest FROM v_tiles JOIN cairn_payloads USING (payload_id) "
                "ORDER BY tile;"
                "SELECT session_id, name FROM cairn_sessions ORDER BY session_id;"
                "SELECT keyframe_id, session_id FROM keyframes ORDER BY keyframe_id");
}

std::map<std::string, MapState> StatesOf(const MapOperation& operation, const fs::path& folder) {
  std::map<std::string, MapState> states;
  for (const std::string& map : operation.maps) {
    states[map] = StateOf(folder / map);
  }
  return states;
}

void ExpectSound(const MapOperation& operation, const fs::path& folder) {
  for (const std::string& map : operation.maps) {
    if (fs::exists(folder / map)) {
      const MapStore store = MapStore::Open((folder / map).string(), OpenMode::kReadWrite);
      EXPECT_THAT(store.Check({}).problems, ::testing::IsEmpty());
    }
  }
}

void ExpectNothingElse(const MapOperation& operation, const fs::path& folder) {
  ExpectSound(operation, folder);  // Only a writer removes the logs when it closes the map.
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  EXPECT_THAT(names, ::testing::UnorderedElementsAreArray(operation.maps));
}

// The folders before and after the operation, and how many writes lie between.
class Rehearsal {
 public:
  explicit Rehearsal(const MapOperation& operation) : operation_(operation) {
    fs::create_directory(before_);
    operation.prepare(before_);
    CopyBefore(after_);
    num_writes_ = RunOnFaultyDisk({}, [&] { operation.run(after_); }).num_writes;
    states_before_ = StatesOf(operation, before_);
    states_after_ = StatesOf(operation, after_);
  }

  int64_t num_writes() const { return num_writes_; }
  fs::path Folder(const std::string& name) const { return dir_.path() / name; }

  void CopyBefore(const fs::path& folder) const {
    fs::remove_all(folder);
    fs::copy(before_, folder, fs::copy_options::recursive);
  }

  // Returns whether the operation has happened.
  bool ExpectWhole(const fs::path& folder) const {
    ExpectSound(operation_, folder);
    const auto states = StatesOf(operation_, folder);
    const bool has_happened = states == states_after_;
    EXPECT_TRUE(has_happened || states == states_before_);
    return has_happened;
  }

  void ExpectRepeatable(const fs::path& folder) const {
    if (!ExpectWhole(folder)) {
      operation_.run(folder);
      EXPECT_EQ(StatesOf(operation_, folder), states_after_);
    }
    ExpectNothingElse(operation_, folder);
  }

 private:
  const MapOperation& operation_;
  TempDir dir_;
  fs::path before_ = dir_.path() / "before";
  fs::path after_ = dir_.path() / "after";
  int64_t num_writes_ = 0;
  std::map<std::string, MapState> states_before_;
  std::map<std::string, MapState> states_after_;
};

}  // namespace

void ExpectWholeVersionsAfterKills(const MapOperation& operation, int count) {
  const Rehearsal rehearsal(operation);
  const fs::path folder = rehearsal.Folder("killed");
  int num_killed = 0;
  for (const int64_t moment : RandomMoments(rehearsal.num_writes(), count, 1)) {
    SCOPED_TRACE("killed at write " + std::to_string(moment));
    rehearsal.CopyBefore(folder);
    const ChildResult result =
        RunOnFaultyDisk({DiskFault::Kind::kKill, moment}, [&] { operation.run(folder); });
    num_killed += result.was_killed ? 1 : 0;
    rehearsal.ExpectRepeatable(folder);
  }
  EXPECT_EQ(num_killed, count);
}

void ExpectWholeVersionsOnFullDisks(const MapOperation& operation, int count) {
  const Rehearsal rehearsal(operation);
  const fs::path folder = rehearsal.Folder("full");
  int num_thrown = 0;
  for (const int64_t moment : RandomMoments(rehearsal.num_writes(), count, 2)) {
    SCOPED_TRACE("full at write " + std::to_string(moment));
    rehearsal.CopyBefore(folder);
    const ChildResult result =
        RunOnFaultyDisk({DiskFault::Kind::kFull, moment}, [&] { operation.run(folder); });
    num_thrown += result.has_thrown ? 1 : 0;
    rehearsal.ExpectRepeatable(folder);
  }
  EXPECT_GT(num_thrown, 0);
}

void ExpectWholeVersionsInCopies(const MapOperation& operation, int count) {
  const Rehearsal rehearsal(operation);
  const fs::path folder = rehearsal.Folder("copied");
  const fs::path copy = rehearsal.Folder("copy");
  for (const int64_t moment : RandomMoments(rehearsal.num_writes(), count, 3)) {
    SCOPED_TRACE("copied at write " + std::to_string(moment));
    rehearsal.CopyBefore(folder);
    fs::remove_all(copy);
    fs::create_directory(copy);
    const auto make_copy = [&] {
      for (const std::string& map : operation.maps) {
        for (const std::string& name : {map, map + "-wal"}) {
          if (fs::exists(folder / name)) {
            fs::copy(folder / name, copy / name);
          }
        }
      }
    };
    RunOnFaultyDisk({DiskFault::Kind::kCall, moment, make_copy}, [&] { operation.run(folder); });
    rehearsal.ExpectRepeatable(copy);
  }
}

}  // namespace cairn::testing
