// A map in an SQLite file; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_SQLITE_BACKEND_H_
#define CAIRN_STORAGE_MAP_INTERNAL_SQLITE_BACKEND_H_

#include <memory>
#include <string>

#include "storage/map/internal/map_backend.h"
#include "storage/map/internal/reader_pool.h"

namespace cairn {

class SqliteBackend : public MapBackend {
 public:
  // Throws as MapStore::Open.
  SqliteBackend(const std::string& path, OpenMode mode);

  const std::string& name() const override { return readers_->path(); }
  std::optional<MapHead> KnownHead() const override { return std::nullopt; }
  std::unique_ptr<db::Connection> Take(ReadDeadline /*deadline*/) override {
    return readers_->Take();
  }
  void GiveBack(std::unique_ptr<db::Connection> connection) override {
    readers_->GiveBack(std::move(connection));
  }
  std::unique_ptr<WriteTransaction> BeginUpdate() override;
  MapFileState FileState() const override;
  std::string LogPath() const override { return name() + "-wal"; }

 private:
  const OpenMode mode_;
  std::unique_ptr<ReaderPool> readers_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_SQLITE_BACKEND_H_
