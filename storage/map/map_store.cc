#include "storage/map/map_store.h"

#include <filesystem>
#include <memory>
#include <thread>
#include <utility>

#include "core/error.h"
#include "storage/database/transaction.h"
#include "storage/map/internal/id_counters.h"
#include "storage/map/internal/map_check.h"
#include "storage/map/internal/map_file.h"
#include "storage/map/internal/map_internal.h"
#include "storage/map/internal/open_map.h"
#include "storage/map/internal/postgres_backend.h"
#include "storage/map/internal/sqlite_backend.h"

namespace cairn {
namespace {

void CreateFilledOnServer(const std::string& url, const std::function<void(MapStore*)>& fill) {
  MapStore store = MapStore::Create(url);
  try {
    fill(&store);
  } catch (...) {
    DropPostgresMap(url);
    throw;
  }
}

// Begins an update, and asks again for as long as `patience` says while another one runs.
std::unique_ptr<WriteTransaction> BeginWriting(MapBackend* backend,
                                               std::chrono::milliseconds patience) {
  constexpr std::chrono::milliseconds kPause(20);
  const auto last_try = std::chrono::steady_clock::now() + patience;
  while (true) {
    try {
      return backend->BeginUpdate();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kConflict ||
          std::chrono::steady_clock::now() + kPause > last_try) {
        throw;
      }
    }
    std::this_thread::sleep_for(kPause);
  }
}

}  // namespace

std::unique_ptr<MapBackend> OpenBackend(const std::string& path, OpenMode mode) {
  if (IsServerAddress(path)) {
    return OpenPostgresMap(path, mode);
  }
  return std::make_unique<SqliteBackend>(path, mode);
}

MapStore::MapStore(std::shared_ptr<OpenMap> map) : map_(std::move(map)) {}
MapStore::MapStore(MapStore&&) noexcept = default;
MapStore& MapStore::operator=(MapStore&&) noexcept = default;
MapStore::~MapStore() = default;

MapStore MapStore::Create(const std::string& path) {
  if (IsServerAddress(path)) {
    CreatePostgresMap(path);
  } else {
    CreateMapFile(path, {});
  }
  return Open(path, OpenMode::kReadWrite);
}

void MapStore::CreateFilled(const std::string& path, const std::function<void(MapStore*)>& fill) {
  if (IsServerAddress(path)) {
    return CreateFilledOnServer(path, fill);
  }
  CreateMapFile(path, [&fill](const std::string& name) {
    MapStore store = Open(name, OpenMode::kReadWrite);
    fill(&store);
  });
}

MapStore MapStore::Open(const std::string& path, OpenMode mode) {
  return MapStore(std::make_shared<OpenMap>(OpenBackend(path, mode)));
}

const std::string& MapStore::path() const { return map_->backend().name(); }

std::string MapStore::ShortName() const {
  return IsServerAddress(path()) ? path() : std::filesystem::path(path()).filename().string();
}

MapFileState MapStore::FileState() const { return map_->backend().FileState(); }

std::string MapStore::LogPath() const { return map_->backend().LogPath(); }

MapSnapshot MapStore::Snapshot(ReadDeadline deadline) const {
  return MapSnapshot(std::make_unique<MapSnapshot::Impl>(map_, deadline));
}

MapStoreStats MapStore::Stats() const { return map_->Stats(); }

MapUpdate MapStore::BeginUpdate(std::chrono::milliseconds patience) {
  return MapUpdate(std::make_unique<MapUpdate::Impl>(BeginWriting(&map_->backend(), patience)));
}

FirstIds MapStore::ReserveIds(const IdCounts& counts, std::chrono::milliseconds patience) {
  const std::unique_ptr<WriteTransaction> transaction = BeginWriting(&map_->backend(), patience);
  db::Connection* connection = transaction->connection();
  const FirstIds ids = {CodebookId(TakeIds(connection, IdCounter::kCodebook, counts.num_codebooks)),
                        SessionId(TakeIds(connection, IdCounter::kSession, counts.num_sessions)),
                        KeyframeId(TakeIds(connection, IdCounter::kKeyframe, counts.num_keyframes)),
                        LandmarkId(TakeLandmarkIds(connection, counts.num_landmarks))};
  transaction->Commit();
  return ids;
}

CheckReport MapStore::Check(const std::function<void(int64_t, int64_t)>& progress) const {
  return map_->Call({}, [&](db::Connection* connection) {
    const db::ReadTransaction transaction(connection);
    return CheckMap(connection, progress);
  });
}

}  // namespace cairn
