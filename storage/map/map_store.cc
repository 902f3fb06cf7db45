#include "storage/map/map_store.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "storage/map/map_check.h"
#include "storage/map/map_file.h"
#include "storage/map/map_internal.h"

namespace cairn {

namespace {

sqlite::Access AccessFor(OpenMode mode) {
  switch (mode) {
    case OpenMode::kReadOnly:
      return sqlite::Access::kReadOnly;
    case OpenMode::kReadWrite:
      return sqlite::Access::kReadWrite;
    case OpenMode::kImmutable:
      return sqlite::Access::kImmutable;
  }
  throw Error(ErrorCode::kInternal, "unknown OpenMode");
}

}  // namespace

struct MapStore::Impl {
  OpenMode mode;
  std::shared_ptr<ReaderPool> readers;  // Shared with the snapshots, which may outlive the store.
};

MapStore::MapStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapStore::MapStore(MapStore&&) noexcept = default;
MapStore& MapStore::operator=(MapStore&&) noexcept = default;
MapStore::~MapStore() = default;

MapStore MapStore::Create(const std::string& path) {
  CreateMapFile(path, {});
  return Open(path, OpenMode::kReadWrite);
}

void MapStore::CreateFilled(const std::string& path, const std::function<void(MapStore*)>& fill) {
  CreateMapFile(path, [&fill](const std::string& name) {
    MapStore store = Open(name, OpenMode::kReadWrite);
    fill(&store);
  });
}

MapStore MapStore::Open(const std::string& path, OpenMode mode) {
  sqlite::Access access = AccessFor(mode);
  PinnedFile file(path);
  std::unique_ptr<sqlite::Connection> first = OpenMapFile(path, &access);
  if (!file.IsAt(path)) {
    throw Error(ErrorCode::kConflict, path + ": was replaced while it was being opened; try again");
  }
  return MapStore(std::make_unique<Impl>(
      Impl{mode, std::make_shared<ReaderPool>(std::move(first), access, std::move(file))}));
}

const std::string& MapStore::path() const { return impl_->readers->path(); }

MapFileState MapStore::FileState() const {
  if (impl_->readers->IsInPlace()) {
    return MapFileState::kInPlace;
  }
  std::error_code error;
  return std::filesystem::exists(path(), error) ? MapFileState::kReplaced : MapFileState::kMissing;
}

std::string MapStore::LogPath() const { return path() + "-wal"; }

MapSnapshot MapStore::Snapshot() const {
  return MapSnapshot(std::make_unique<MapSnapshot::Impl>(impl_->readers));
}

MapUpdate MapStore::BeginUpdate() {
  if (impl_->mode != OpenMode::kReadWrite) {
    throw Error(ErrorCode::kConflict, path() + ": was opened read-only");
  }
  return MapUpdate(std::make_unique<MapUpdate::Impl>(path()));
}

CheckReport MapStore::Check(const std::function<void(int64_t, int64_t)>& progress) const {
  const MapSnapshot::Impl snapshot(impl_->readers);
  return CheckMap(snapshot.connection.get(), progress);
}

}  // namespace cairn
