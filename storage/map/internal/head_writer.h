// Writes the rows of the version that an update becomes; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_HEAD_WRITER_H_
#define CAIRN_STORAGE_MAP_INTERNAL_HEAD_WRITER_H_

#include <cstdint>
#include <memory>
#include <span>

#include "storage/database/connection.h"
#include "storage/map/internal/layer_extent.h"
#include "storage/map/internal/running_totals.h"
#include "storage/map/map_store.h"

namespace cairn {

// Inserts rows into the tables of the latest version (the head) and moves removed rows to the
// tables of the past (docs/formats/map_v1.md, "Versions"). A row that one update removes and
// inserts again keeps its `since`. Works in the open transaction of the connection, which must
// outlive the writer.
class HeadWriter {
 public:
  explicit HeadWriter(db::Connection* connection);

  // The version that the update becomes.
  int64_t next_version() const { return next_version_; }

  // Id 0 stands for a new id, an empty created_at for the current time. Any other id belongs to a
  // session of an earlier version.
  SessionId InsertSession(const SessionRecord& session);
  // The session must not have keyframes.
  void RetireSession(SessionId session_id);

  // Id 0 stands for a new id. Any other id belongs to a keyframe of an earlier version.
  KeyframeId InsertKeyframe(const KeyframeRecord& keyframe);
  // Does nothing if there is no such keyframe.
  void RetireKeyframe(KeyframeId keyframe_id);

  // Inserts or replaces a tile. Equal payloads are stored once.
  PayloadId PutTile(TileRecord tile, std::span<const uint8_t> payload);
  // Inserts or replaces a tile whose payload is in the map.
  void PutStoredTile(const TileRecord& tile);
  // Does nothing if there is no such tile.
  void RetireTile(TileId tile_id);

  // Returns the id of the codebook with equal bytes. Inserts a row if there is none, with
  // `codebook_id` or, if that is 0, with a new id.
  CodebookId StoreCodebook(const Codebook& codebook, CodebookId codebook_id);
  // Id 0 stands for no codebook.
  void SetCurrentCodebook(CodebookId codebook_id);

  // Deletes the payload if no version has it. Returns the number of bytes deleted.
  int64_t DropUnusedPayload(PayloadId payload_id);

  // Inserts the row of cairn_versions and, in a GeoPackage, updates gpkg_contents.
  void AddVersion(const VersionNote& note);

 private:
  // Adds the payload's sessions and the tile to cairn_session_tiles.
  void NoteSessions(TileId tile_id, std::span<const uint8_t> payload);
  PayloadId StorePayload(std::span<const uint8_t> payload);
  void InsertTile(const TileRecord& tile);

  db::Connection* connection_;
  int64_t next_version_;
  RunningTotals totals_;
  std::unique_ptr<LayerExtents> extents_;  // Null if the map is no GeoPackage.
};

// Inserts what every map has into new tables: the row of cairn_map and that of version 1.
void AddFirstVersion(db::Connection* connection);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_HEAD_WRITER_H_
