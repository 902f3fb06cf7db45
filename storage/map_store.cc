#include "storage/map_store.h"

#include <utility>

#include "core/error.h"
#include "storage/map_check.h"
#include "storage/map_file.h"
#include "storage/map_internal.h"

namespace cairn {

struct MapStore::Impl {
  OpenMode mode;
  std::shared_ptr<ReaderPool> readers;  // Shared with the snapshots, which may live longer.
};

MapStore::MapStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapStore::MapStore(MapStore&&) noexcept = default;
MapStore& MapStore::operator=(MapStore&&) noexcept = default;
MapStore::~MapStore() = default;

MapStore MapStore::Create(const std::string& path) {
  CreateMapFile(path);
  return Open(path, OpenMode::kReadWrite);
}

MapStore MapStore::Open(const std::string& path, OpenMode mode) {
  sqlite::Access access =
      mode == OpenMode::kReadOnly ? sqlite::Access::kReadOnly : sqlite::Access::kReadWrite;
  std::unique_ptr<sqlite::Connection> first = OpenMapFile(path, &access);
  return MapStore(
      std::make_unique<Impl>(Impl{mode, std::make_shared<ReaderPool>(std::move(first), access)}));
}

const std::string& MapStore::path() const { return impl_->readers->path(); }

MapSnapshot MapStore::Snapshot() const {
  return MapSnapshot(std::make_unique<MapSnapshot::Impl>(impl_->readers));
}

MapUpdate MapStore::BeginUpdate() {
  if (impl_->mode == OpenMode::kReadOnly) {
    throw Error(ErrorCode::kConflict, path() + ": was opened for reading only");
  }
  return MapUpdate(std::make_unique<MapUpdate::Impl>(path()));
}

CheckReport MapStore::Check(const std::function<void(int64_t, int64_t)>& progress) const {
  const MapSnapshot::Impl snapshot(impl_->readers);
  return CheckMap(snapshot.connection.get(), progress);
}

}  // namespace cairn
