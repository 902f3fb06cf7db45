#include "http/service/served_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/logging.h"
#include "core/wire/fingerprint.h"
#include "storage/map/mount_point.h"

namespace cairn {
namespace {

constexpr char kMountedAlone[] =
    "the map file is mounted without its folder; updates may stay invisible";
constexpr char kMountTheFolder[] = "mount the folder of the map, and name the file in it";

// True if queries that read this open map see this version of the map with this name.
bool SeesVersion(const ServedMap& map, MapVersion version) {
  try {
    return map.store().Snapshot().version() == version;
  } catch (const Error&) {
    return false;
  }
}

// True if `next`, opened just now, is the map that `open` reads. The pages that `open` keeps in
// memory show an old version if the file was overwritten by a copy of the same map.
bool IsSameMap(const ServedMap& next, const ServedMap& open) {
  const bool is_file = !open.store().LogPath().empty();
  return next.created_at == open.created_at &&
         Value(next.version_when_opened) >= Value(open.version_when_opened) &&
         (!is_file || SeesVersion(open, next.version_when_opened));
}

std::string Alphanumeric(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isalnum(c) == 0; });
  return text;
}

}  // namespace

FileStamp FileStamp::Of(const std::string& path) {
  std::error_code error;
  return {.written_at = std::filesystem::last_write_time(path, error),
          .num_bytes = std::filesystem::file_size(path, error)};
}

// A copy of a map that was changed on its own keeps the date and the payload ids of the original.
// The tag therefore also covers the recorded facts about the tile's contents.
std::string ServedMap::TileTag(const TileRecord& tile) const {
  Fingerprint contents;
  for (const int64_t count :
       {tile.num_bytes, tile.num_landmarks, tile.num_descriptors, tile.num_keyframes}) {
    contents.Add(static_cast<uint64_t>(count));
  }
  const GeoBox& box = tile.landmark_bounds;
  for (const double number :
       {tile.min_h_m, tile.max_h_m, box.south_rad, box.west_rad, box.north_rad, box.east_rad}) {
    contents.Add(number);
  }
  return fmt::format("\"{}{:016x}-{}\"", Alphanumeric(created_at), contents.value(),
                     Value(tile.payload_id));
}

ServedMaps::ServedMaps(const ServedMapOptions& options)
    : options_(options), current_(Open(OpenMode::kServing)) {
  checked_ = current_->stamp;
  if (current_->is_mounted_alone) {
    SetProblem(kMountedAlone, kMountTheFolder);
  }
}

std::shared_ptr<ServedMap> ServedMaps::Open(OpenMode mode) const {
  return Open(mode,
              std::make_shared<TileCache>(options_.cache_bytes, options_.localizer.matching.index));
}

std::shared_ptr<ServedMap> ServedMaps::Open(OpenMode mode, std::shared_ptr<TileCache> cache) const {
  const FileStamp stamp = FileStamp::Of(options_.path);
  auto store = std::make_shared<const MapStore>(MapStore::Open(options_.path, mode));
  auto localizer = std::make_unique<Localizer>(store, options_.localizer, std::move(cache));
  const MapSnapshot snapshot = store->Snapshot();
  const MapInfo info = snapshot.Info();
  snapshot.CurrentCodebook();  // Throws if it is damaged.
  return std::make_shared<ServedMap>(
      ServedMap{.localizer = std::move(localizer),
                .created_at = info.created_at,
                .version_when_opened = info.version,
                .is_stand_in = mode == OpenMode::kImmutable,
                .is_mounted_alone = IsMountPoint(options_.path),
                .stamp = stamp,
                .log = std::make_shared<const PinnedFile>(store->LogPath())});
}

std::shared_ptr<const ServedMap> ServedMaps::Current() const {
  const std::lock_guard lock(mutex_);
  return current_;
}

std::string ServedMaps::Problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void ServedMaps::Refresh() { Look(/*is_forced=*/false); }

void ServedMaps::Reload() { Look(/*is_forced=*/true); }

void ServedMaps::Look(bool is_forced) {
  const std::lock_guard look_lock(look_mutex_);
  const bool is_alone = ReleaseReplaced();
  const std::shared_ptr<const ServedMap> current = Current();
  try {
    switch (current->store().FileState()) {
      case MapFileState::kMissing:
        return SetProblem("the map file is missing",
                          "the server keeps serving the map that it has open");
      case MapFileState::kReplaced:
        return TakeReplacement();
      case MapFileState::kInPlace:
        break;
    }
    if (current->is_stand_in) {
      if (is_alone) {
        TakePlaceOfStandIn();
      }
    } else if (is_forced || must_reload_) {
      must_reload_ = true;
      TakeOverwritten();
      must_reload_ = false;
    } else if (current->is_mounted_alone) {
      FollowMountedFile(*current);
    } else {
      FollowWrites(*current);
    }
  } catch (const std::exception& error) {
    SetProblem("the map file cannot be opened; the server keeps serving an older map",
               error.what());
  }
}

bool ServedMaps::ReleaseReplaced() {
  std::erase_if(replaced_, [](const auto& map) { return map.use_count() == 1; });
  return replaced_.empty();
}

void ServedMaps::ReplaceCurrent(std::shared_ptr<const ServedMap> next) {
  checked_ = next->stamp;
  unsettled_.reset();
  std::unique_lock lock(mutex_);
  current_.swap(next);
  lock.unlock();
  // Running queries hold the tiles that they use.
  if (next->localizer->cache() != Current()->localizer->cache()) {
    next->localizer->cache()->Clear();
  }
  replaced_.push_back(std::move(next));
}

// SQLite shares the write-ahead log and its index among all connections to one file name, even if
// the connections have different files open. While the old map is open, the new one is therefore
// read without log and index.
void ServedMaps::TakeReplacement() {
  std::shared_ptr<ServedMap> next = Open(OpenMode::kImmutable);
  const std::shared_ptr<const ServedMap> old = Current();
  if (!old->is_stand_in) {
    replaced_log_ = old->log;
  }
  LogInfo("{} was replaced: serving the map created at {} instead of the one created at {}",
          options_.path, next->created_at, old->created_at);
  ReplaceCurrent(std::move(next));
  SetProblem("", "");
}

void ServedMaps::TakeOverwritten() {
  std::shared_ptr<ServedMap> next = Open(OpenMode::kServing);
  if (IsSameMap(*next, *Current())) {
    LogInfo("{} was opened again: the same map", options_.path);
    SetProblem("", "");
  } else {
    Take(std::move(next));
  }
}

void ServedMaps::Take(std::shared_ptr<ServedMap> next) {
  LogInfo("{} was opened again: another map, now being served", options_.path);
  ReplaceCurrent(std::move(next));
  SetProblem("", "");
}

void ServedMaps::FollowWrites(const ServedMap& current) {
  if (FileStamp::Of(options_.path) == checked_) {
    return SetProblem("", "");
  }
  std::shared_ptr<ServedMap> next = Open(OpenMode::kServing);
  if (IsSameMap(*next, current)) {
    checked_ = next->stamp;
    unsettled_.reset();
    return SetProblem("", "");
  }
  if (unsettled_ == next->stamp) {
    return Take(std::move(next));
  }
  unsettled_ = next->stamp;
  SetProblem("the map file was overwritten; its new map is served when it no longer changes",
             "write maps to another name and rename them, because queries of this moment may see "
             "both maps");
}

void ServedMaps::FollowMountedFile(const ServedMap& current) {
  if (FileStamp::Of(options_.path) != current.stamp) {
    LogInfo("{} has changed: opening it again", options_.path);
    ReplaceCurrent(Open(OpenMode::kServing));
  }
  SetProblem(kMountedAlone, kMountTheFolder);
}

void ServedMaps::TakePlaceOfStandIn() {
  const std::shared_ptr<const ServedMap> stand_in = Current();
  const std::string log_path = stand_in->store().LogPath();
  if (LogIsOfReplacedMap(log_path)) {
    return SetProblem(
        "the write-ahead log beside the map file belongs to the previous map; updates are not "
        "visible",
        fmt::format("remove {} and its -shm file before any program writes to the map", log_path));
  }
  std::shared_ptr<ServedMap> next = Open(OpenMode::kServing, stand_in->localizer->cache());
  if (next->created_at != stand_in->created_at ||
      stand_in->store().FileState() != MapFileState::kInPlace) {
    return;  // The file is being replaced again; the next check sees it.
  }
  ReplaceCurrent(std::move(next));
  replaced_log_.reset();
  SetProblem("", "");
}

bool ServedMaps::LogIsOfReplacedMap(const std::string& log_path) const {
  std::error_code error;
  const auto num_bytes = std::filesystem::file_size(log_path, error);
  return !error && num_bytes > 0 && replaced_log_ != nullptr && replaced_log_->IsAt(log_path);
}

void ServedMaps::SetProblem(const std::string& problem, const std::string& detail) {
  {
    const std::lock_guard lock(mutex_);
    if (problem == problem_) {
      return;
    }
    problem_ = problem;
  }
  if (problem.empty()) {
    LogInfo("{}: the problem with the map file is resolved", options_.path);
  } else {
    LogWarning("{}: {}: {}", options_.path, problem, detail);
  }
}

}  // namespace cairn
