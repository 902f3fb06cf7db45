// A map: one SQLite file that is also a GeoPackage, or a PostgreSQL database. Creates, opens, reads
// and updates maps.
#ifndef CAIRN_STORAGE_MAP_MAP_STORE_H_
#define CAIRN_STORAGE_MAP_MAP_STORE_H_

#include <Eigen/Core>
#include <chrono>
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
#include "storage/map/map_versions.h"
#include "storage/map/session_accuracy.h"

namespace cairn {

class OpenMap;  // Private to storage.

// The index's record of one tile: everything except the payload bytes.
struct TileRecord {
  TileId tile_id;
  PayloadId payload_id{};
  std::string digest;  // XXH3-128 of the payload, 32 hexadecimal digits; the key of caches.
  CodebookId codebook_id{};
  int64_t num_landmarks = 0;
  int64_t num_descriptors = 0;
  int64_t num_keyframes = 0;
  int64_t num_bytes = 0;  // Size of the encoded payload.
  double min_h_m = 0.0;   // Ellipsoidal heights of the tile's keyframes.
  double max_h_m = 0.0;
  GeoBox landmark_bounds;  // Box of the landmarks; they can lie far outside the tile's square.
};

// One ingested reconstruction.
struct SessionRecord {
  SessionId id{};
  std::string name;        // Unique; re-ingesting a name replaces the session.
  std::string source;      // Origin of the reconstruction, for people.
  std::string created_at;  // UTC, RFC 3339; set by the store.
  // When the photos were taken: UTC, "2026-01-31T12:00:00Z". If it is empty, the store sets it to
  // created_at.
  std::string recorded_at;
  std::string content_digest;  // Of what was ingested: lower-case hexadecimal, or empty.
  int64_t num_images = 0;
  int64_t num_landmarks = 0;  // In the reconstruction, before selection.
  double georef_median_residual_m = 0.0;
  std::optional<SessionAccuracy> accuracy;  // Empty if nobody estimated it.
};

// One mapping image.
struct KeyframeRecord {
  KeyframeId id{};
  SessionId session_id{};
  TileId tile_id;  // The tile that contains the camera.
  std::string image_name;
  Camera camera;
  Rigid3d cam_from_ecef;
};

// Numbers of ids.
struct IdCounts {
  int64_t num_codebooks = 0;
  int64_t num_sessions = 0;
  int64_t num_keyframes = 0;
  uint64_t num_landmarks = 0;
};

// The first id of each kind; the others follow it.
struct FirstIds {
  CodebookId codebook{};
  SessionId session{};
  KeyframeId keyframe{};
  LandmarkId landmark{};
};

struct MapInfo : MapTotals {
  MapVersion version{};
  std::string created_at;
  int64_t file_bytes = 0;
};

struct TilePageRequest {
  std::optional<GeoBox> box;    // Without a box, all tiles.
  std::optional<TileId> after;  // Only tiles with larger ids; TilePage::resume_after goes here.
  int64_t limit = 1000;
};

struct TilePage {
  std::vector<TileRecord> tiles;  // At most `limit`, ordered by tile id.
  // The id after which the search goes on; empty at the end. A page may have fewer tiles than
  // `limit`, or none, and yet not be the last one, because the work for a page is bounded.
  std::optional<TileId> resume_after;
};

// The time by which a read must end; empty for no limit.
using ReadDeadline = std::optional<std::chrono::steady_clock::time_point>;

// A consistent view of one map version. A snapshot is a version number: it holds no transaction and
// no connection, is valid until its version is pruned, and is safe to use from any thread. Each
// call borrows a connection, unless a cache has the result.
//
// Calls throw Error(kUnavailable) if the version was pruned meanwhile; take a new snapshot then.
// With PostgreSQL, they also throw Error(kUnavailable) if PostgreSQL does not answer by the
// deadline. Reads of a file ignore the deadline.
class MapSnapshot {
 public:
  MapSnapshot(MapSnapshot&&) noexcept;
  MapSnapshot& operator=(MapSnapshot&&) noexcept;
  ~MapSnapshot();

  MapVersion version() const;
  // True if PostgreSQL is silent, so that the map may have a newer version. Always false for a
  // file.
  bool is_stale() const;
  MapInfo Info() const;  // Takes constant time.

  // Returns the newest `limit` versions up to this one, newest first, without pruned versions.
  std::vector<VersionRecord> Versions(int64_t limit) const;
  // Returns the tiles whose payloads differ between two versions, ordered by tile id. Throws
  // Error(kNotFound), which names the versions of the map, if one of the two is not among them.
  std::vector<TileChange> Diff(MapVersion from, MapVersion to) const;

  // Returns the tiles whose square's bounding box intersects `box`, ordered by tile id. The store
  // caches tile records and empty squares, so boxes of a few kilometers rarely read the map.
  std::vector<TileRecord> FindTiles(const GeoBox& box) const;
  // Returns the first `limit` tiles of the map by tile id.
  std::vector<TileRecord> AllTiles(int64_t limit) const;
  // Lists tiles page by page. The work for a page does not grow with the map or with the box.
  TilePage FindTilePage(const TilePageRequest& request) const;
  std::optional<TileRecord> FindTile(TileId tile_id) const;

  // Returns the encoded bytes of a tile. Payload ids come from the map, so a missing payload of a
  // version that was not pruned is damage: Error(kMapDamaged).
  LargeVector<uint8_t> LoadPayload(PayloadId payload_id) const;

  // The store caches decoded codebooks. Throws Error(kMapDamaged) if the codebook is missing or
  // does not decode.
  std::shared_ptr<const Codebook> LoadCodebook(CodebookId codebook_id) const;
  // Returns the codebook that encodes new sessions, or null if nothing has been ingested yet.
  std::shared_ptr<const Codebook> CurrentCodebook() const;

  std::vector<SessionRecord> Sessions() const;
  std::optional<SessionRecord> FindSession(const std::string& name) const;
  // Returns the tiles whose content of this or a later version names, or once named, the session.
  std::vector<TileId> TilesOfSession(SessionId session_id) const;
  // Returns the accuracies that the map has of these sessions, of any version, in any order.
  std::vector<SessionAccuracy> AccuraciesOf(const std::vector<SessionId>& session_ids) const;
  std::vector<KeyframeRecord> KeyframesOfSession(SessionId session_id) const;
  std::vector<KeyframeRecord> KeyframesOfTile(TileId tile_id) const;

  // The XXH3-128 hash of the codebook's bytes, 32 hexadecimal digits. Maps with equal digests can
  // be merged. Throws Error(kMapDamaged) if the map does not have the codebook.
  std::string CodebookDigest(CodebookId codebook_id) const;
  // Returns the id under which the map has this codebook, of any version; 0 if it does not have it.
  CodebookId FindCodebook(const Codebook& codebook) const;
  // All landmarks of all versions have smaller ids.
  LandmarkId NextLandmarkId() const;

 private:
  friend class MapStore;
  struct Impl;
  explicit MapSnapshot(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A write transaction that either becomes the next map version or changes nothing. At most one
// exists per map file, across processes. Use each update from one thread. Earlier versions keep the
// content that an update removes.
class MapUpdate {
 public:
  MapUpdate(MapUpdate&&) noexcept;
  ~MapUpdate();  // Rolls back unless published.

  MapVersion base_version() const;  // The version that this update changes.

  // These reads include what this update has written.
  std::optional<TileRecord> FindTile(TileId tile_id) const;
  LargeVector<uint8_t> LoadPayload(PayloadId payload_id) const;
  std::optional<SessionRecord> FindSession(const std::string& name) const;
  std::vector<SessionRecord> Sessions() const;  // Ordered by id.
  std::vector<TileId> TilesOfSession(SessionId session_id) const;
  std::vector<KeyframeRecord> KeyframesOfTile(TileId tile_id) const;  // Ordered by id.
  std::shared_ptr<const Codebook> CurrentCodebook() const;

  // Each added row gets a new id, unless `reserved` is an unused id from ReserveIds.

  // Adds a codebook and makes it current. Ignores `codebook.id`. A codebook that the map has
  // already keeps its id.
  CodebookId AddCodebook(const Codebook& codebook, CodebookId reserved = CodebookId{});

  // Ignores `id` and `created_at`. Throws Error(kConflict) if the name is taken,
  // Error(kInvalidArgument) if `recorded_at` is not a time or `content_digest` not hexadecimal.
  SessionId AddSession(const SessionRecord& session, SessionId reserved = SessionId{});
  // Deletes the session's row and keyframes. The caller must rewrite or remove the session's tiles.
  void RemoveSession(SessionId session_id);

  // Ignores `id`.
  KeyframeId AddKeyframe(const KeyframeRecord& keyframe, KeyframeId reserved = KeyframeId{});
  // Deletes the keyframe's row, if there is one. The caller must rewrite the keyframe's tile.
  void RemoveKeyframe(KeyframeId keyframe_id);

  // Reserves `count` consecutive landmark ids and returns the first.
  LandmarkId ReserveLandmarkIds(uint64_t count);
  // Returns the ids that come next. All ids that were ever reserved or given are smaller.
  FirstIds NextIds() const;

  // Inserts or replaces a tile and its payload. The tile's codebook must be in the map. Ignores
  // `payload_id` and `num_bytes`. Returns the payload's id; equal bytes share an id. Putting the
  // bytes that the tile already has changes nothing.
  PayloadId PutTile(const TileRecord& tile, std::span<const uint8_t> payload);
  void RemoveTile(TileId tile_id);

  // Restores the tiles, keyframes, sessions and the current codebook of an earlier version, with
  // identical payloads. Does not rewind the counters of ids. Throws as MapSnapshot::Diff.
  void RestoreVersion(MapVersion version);

  // Deletes the versions before `oldest_kept` and the content that only those versions have.
  // Returns the number of payload bytes that this removes.
  int64_t PruneBefore(MapVersion oldest_kept);

  // Copies tiles of another map with their keyframes, sessions and codebook, and keeps their ids.
  // This map must be new and empty.
  void CopyTiles(const MapSnapshot& from, const std::vector<TileRecord>& tiles);

  // Commits. After Publish, only the destructor may be called.
  MapVersion Publish(const VersionNote& note = {});

 private:
  friend class MapStore;
  struct Impl;
  explicit MapUpdate(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

enum class OpenMode {
  kReadOnly,
  kReadWrite,
  // Read-only, for a program that answers queries. With PostgreSQL, a thread watches the latest
  // version, so taking a snapshot reads nothing. While PostgreSQL is silent, snapshots are stale,
  // and reads fail at once instead of waiting.
  kServing,
  // For a file that nobody writes to. Reads without locks and ignores any write-ahead log. The
  // store does not see updates, and must not be used while the map is updated.
  kImmutable,
};

// The state of the path of an open map.
enum class MapFileState { kInPlace, kReplaced, kMissing };

struct CheckReport {
  int64_t num_tiles_checked = 0;      // A tile counts once for each of its contents.
  std::vector<std::string> problems;  // Empty if the map is sound.
};

// How often an open map was read.
struct MapStoreStats {
  int64_t num_calls = 0;         // Connections borrowed for reading, each for one call.
  int64_t num_failed_calls = 0;  // Of these, those that ended with Error(kUnavailable).
};

// An open map. Safe to call from any thread. If another file takes the map's path, the store keeps
// reading the file that it opened, and the number of simultaneous reads can no longer grow.
class MapStore {
 public:
  // `path` is a file or a URL such as "postgresql://cairn@db1,db2/lund" (docs/postgresql.md).

  // Creates an empty map of version 1. Throws Error(kConflict) if the file exists or the database
  // has a map, and Error(kIo) if the map cannot be created.
  static MapStore Create(const std::string& path);

  // Creates an empty map and lets `fill` write its content. The file gets its name once `fill`
  // returns. If `fill` throws, neither file nor database has the map. If the process dies, there is
  // no file, but a database has an empty map. Throws as Create.
  static void CreateFilled(const std::string& path, const std::function<void(MapStore*)>& fill);

  // Throws:
  //  - Error(kNotFound) if there is no file;
  //  - Error(kBadInput) if the file is not a Cairn map, with a guess of its kind;
  //  - Error(kMapDamaged) if the file fails its first checks;
  //  - Error(kConflict) if the map needs a newer Cairn, or is replaced while it is being opened.
  // With PostgreSQL also:
  //  - Error(kInvalidArgument) if the URL is invalid or holds a password;
  //  - Error(kIo) if PostgreSQL refuses the role, the password or the encryption;
  //  - Error(kUnavailable) if no host answers, or Cairn was built without libpq.
  static MapStore Open(const std::string& path, OpenMode mode);

  MapStore(MapStore&&) noexcept;
  MapStore& operator=(MapStore&&) noexcept;
  ~MapStore();

  const std::string& path() const;
  // What summaries of versions call the map: the name of a file, or the URL of a database.
  std::string ShortName() const;
  MapFileState FileState() const;
  // Returns the path of the write-ahead log, which need not exist; empty with PostgreSQL. SQLite
  // uses the file of this name as the log of any map opened at this path, even a log that another
  // map left behind.
  std::string LogPath() const;

  // Returns a snapshot of the latest version. Reads the number of that version, unless a thread
  // watches it (kServing). Reads of the snapshot end at the deadline.
  MapSnapshot Snapshot(ReadDeadline deadline = {}) const;
  MapStoreStats Stats() const;

  // Throws Error(kConflict) if the store is not open for writing, or if another update is still
  // open after `patience`; Error(kIo) if PostgreSQL's role may not write.
  MapUpdate BeginUpdate(std::chrono::milliseconds patience = {});

  // Reserves consecutive ids for a later update, in a transaction of its own that makes no version.
  // Ids that are never used leave a gap. Throws as BeginUpdate.
  FirstIds ReserveIds(const IdCounts& counts, std::chrono::milliseconds patience = {});

  // Checks the integrity of the database and of every payload of every version. `progress` may be
  // empty; it receives the number of tiles done and the total.
  CheckReport Check(const std::function<void(int64_t, int64_t)>& progress) const;

 private:
  explicit MapStore(std::shared_ptr<OpenMap> map);
  std::shared_ptr<OpenMap> map_;  // Shared with the snapshots, which may outlive the store.
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_STORE_H_
