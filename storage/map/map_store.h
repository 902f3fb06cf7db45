// The map file: one SQLite database that is also a GeoPackage. Create, open, read, update.
#ifndef CAIRN_STORAGE_MAP_MAP_STORE_H_
#define CAIRN_STORAGE_MAP_MAP_STORE_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geodesy.h"
#include "core/large_vector.h"
#include "core/rigid3.h"
#include "core/tile_id.h"
#include "storage/codebook/codebook.h"
#include "storage/ids.h"

namespace cairn {

// One tile as the index knows it; everything but the payload bytes.
struct TileRecord {
  TileId tile_id;
  PayloadId payload_id{};
  CodebookId codebook_id{};
  int64_t num_landmarks = 0;
  int64_t num_descriptors = 0;
  int64_t num_keyframes = 0;
  int64_t num_bytes = 0;  // Of the encoded payload.
  double min_h_m = 0.0;   // Ellipsoidal heights of the tile's keyframes.
  double max_h_m = 0.0;
  GeoBox landmark_bounds;  // Of the landmarks, which can reach far outside the square.
};

// One ingested reconstruction.
struct SessionRecord {
  SessionId id{};
  std::string name;        // Unique; re-ingesting a name replaces the session.
  std::string source;      // Where it came from, for people.
  std::string created_at;  // UTC, RFC 3339; set by the store.
  int64_t num_images = 0;
  int64_t num_landmarks = 0;  // In the reconstruction, before selection.
  double georef_median_residual_m = 0.0;
};

// One mapping image.
struct KeyframeRecord {
  KeyframeId id{};
  SessionId session_id{};
  TileId tile_id;  // The tile it stands in.
  std::string image_name;
  Camera camera;
  Rigid3d cam_from_ecef;
};

struct MapInfo {
  MapVersion version{};
  std::string created_at;
  int64_t num_sessions = 0;
  int64_t num_keyframes = 0;
  int64_t num_tiles = 0;
  int64_t num_landmarks = 0;  // Sum over tiles; a landmark in two tiles counts twice.
  int64_t num_descriptors = 0;
  int64_t payload_bytes = 0;
  int64_t file_bytes = 0;
  std::optional<GeoBox> bounds;  // Nothing if the map is empty.
};

// A consistent view of one map version for as long as it lives; holds a read transaction. Keep it
// for one query, not longer: the write-ahead log cannot shrink past it. One thread at a time.
class MapSnapshot {
 public:
  MapSnapshot(MapSnapshot&&) noexcept;
  MapSnapshot& operator=(MapSnapshot&&) noexcept;
  ~MapSnapshot();

  MapVersion version() const;
  MapInfo Info() const;

  // Tiles whose square's bounding box meets the box, ordered by tile id.
  std::vector<TileRecord> FindTiles(const GeoBox& box) const;
  // The first `limit` tiles of the map by tile id.
  std::vector<TileRecord> AllTiles(int64_t limit) const;
  std::optional<TileRecord> FindTile(TileId tile_id) const;

  // The encoded bytes of a tile. Ids come from the map itself, so a payload that this
  // version does not have is damage: Error(kMapDamaged).
  LargeVector<uint8_t> LoadPayload(PayloadId payload_id) const;

  // Cached by the store. Throws Error(kMapDamaged) if it is missing or does not decode.
  std::shared_ptr<const Codebook> LoadCodebook(CodebookId codebook_id) const;
  // The codebook new sessions are coded with; nothing if nothing was ingested yet.
  std::shared_ptr<const Codebook> CurrentCodebook() const;

  std::vector<SessionRecord> Sessions() const;
  std::optional<SessionRecord> FindSession(const std::string& name) const;
  std::vector<KeyframeRecord> KeyframesOfSession(SessionId session_id) const;

 private:
  friend class MapStore;
  struct Impl;
  explicit MapSnapshot(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A write transaction that becomes the next map version, or nothing at all. At most one exists per
// map file, across processes. One thread.
class MapUpdate {
 public:
  MapUpdate(MapUpdate&&) noexcept;
  ~MapUpdate();  // Rolls back unless published.

  // Reads see what was written in this update.
  std::optional<TileRecord> FindTile(TileId tile_id) const;
  LargeVector<uint8_t> LoadPayload(PayloadId payload_id) const;
  std::optional<SessionRecord> FindSession(const std::string& name) const;
  std::vector<TileId> TilesOfSession(SessionId session_id) const;
  std::shared_ptr<const Codebook> CurrentCodebook() const;

  // Ignores `id` and makes it current.
  CodebookId AddCodebook(const Codebook& codebook);

  // Ignores `id` and `created_at`. Throws Error(kConflict) if the name is taken.
  SessionId AddSession(const SessionRecord& session);
  // Deletes the session's row and keyframes. The caller rewrites or removes its tiles.
  void RemoveSession(SessionId session_id);

  // Ignores `id`.
  KeyframeId AddKeyframe(const KeyframeRecord& keyframe);

  // Reserves `count` consecutive landmark ids and returns the first.
  LandmarkId ReserveLandmarkIds(uint64_t count);

  // Inserts or replaces a tile and its payload. Its codebook must be in the map. Ignores
  // `payload_id` and `num_bytes` and returns the new payload id.
  PayloadId PutTile(const TileRecord& tile, std::span<const uint8_t> payload);
  void RemoveTile(TileId tile_id);

  // Commits. Nothing may be called after it but the destructor.
  MapVersion Publish();

 private:
  friend class MapStore;
  struct Impl;
  explicit MapUpdate(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

enum class OpenMode {
  kReadOnly,
  kReadWrite,
  // For reading a file that nobody writes to: without locks, and as if there were no write-ahead
  // log beside it. The store does not see updates, and may not be used while there are any.
  kImmutable,
};

// What the name of an open map stands for now.
enum class MapFileState { kInPlace, kReplaced, kMissing };

struct CheckReport {
  int64_t num_tiles_checked = 0;
  std::vector<std::string> problems;  // Empty if the map is sound.
};

// An open map file. Safe to call from any thread. It stays the same file when another one takes its
// name; then no more snapshots can be open at a time than there were before.
class MapStore {
 public:
  // Makes an empty map, which has version 1. Throws Error(kConflict) if the file exists, Error(kIo)
  // if it cannot be made.
  static MapStore Create(const std::string& path);

  // Throws Error(kNotFound) if there is no file, Error(kBadInput) if it is not a Cairn map (says
  // what it seems to be), Error(kMapDamaged) if it fails its first checks, Error(kConflict) if it
  // needs a newer Cairn, or is replaced while it is being opened.
  static MapStore Open(const std::string& path, OpenMode mode);

  MapStore(MapStore&&) noexcept;
  MapStore& operator=(MapStore&&) noexcept;
  ~MapStore();

  const std::string& path() const;
  MapFileState FileState() const;
  // The name of the write-ahead log, which need not be there. Whoever opens a map by this path
  // takes the file of that name for its log, also if another map has left it.
  std::string LogPath() const;

  MapSnapshot Snapshot() const;

  // Throws Error(kConflict) if the store is not open for writing or another update is open.
  MapUpdate BeginUpdate();

  // Integrity of the database and of every payload (checksum and decode). `progress` (may be empty)
  // gets tiles done and total.
  CheckReport Check(const std::function<void(int64_t, int64_t)>& progress) const;

 private:
  struct Impl;
  explicit MapStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_STORE_H_
