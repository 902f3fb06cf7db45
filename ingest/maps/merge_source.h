// One of two maps that are merged. Private to ingest.
#ifndef CAIRN_INGEST_MAPS_MERGE_SOURCE_H_
#define CAIRN_INGEST_MAPS_MERGE_SOURCE_H_

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/rigid3.h"
#include "ingest/codebook/transcoder.h"
#include "ingest/maps/map_motion.h"
#include "ingest/place/tile_memory.h"
#include "ingest/tiles/renumber_tile.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

class MergeSource {
 public:
  MergeSource(const MapStore& store, std::shared_ptr<TileMemory> memory)
      : store_(store),
        snapshot_(store.Snapshot()),
        tiles_(snapshot_, std::move(memory)),
        codebook_(snapshot_.CurrentCodebook()) {}
  MergeSource(const MergeSource&) = delete;
  MergeSource& operator=(const MergeSource&) = delete;

  const MapStore& store() const { return store_; }
  const std::string& path() const { return store_.path(); }
  const MapSnapshot& snapshot() const { return snapshot_; }
  // The tiles as they are stored, in the memory of the merge.
  const RememberedTiles& tiles() const { return tiles_; }
  // Null if nothing was ingested into the map.
  const std::shared_ptr<const Codebook>& codebook() const { return codebook_; }
  // Names the version without the folder of the file.
  std::string Describe() const;

  // From now on, tiles come in the codes of another codebook. Throws as Transcoder.
  void RecodeTo(std::shared_ptr<const Codebook> codebook);
  // From now on, keyframes and landmarks stand elsewhere, in the tiles that contain them there. A
  // landmark of two tiles that meet in one keeps the descriptors and the history of one of them;
  // see MapMotion.
  void Move(const Sim3d& moved_from_ecef);
  // Landmarks of this map that get ids of the other map in place of their own.
  void Link(std::unordered_map<LandmarkId, LandmarkId> links) { links_ = std::move(links); }

  std::vector<TileId> TileIds() const;
  // Returns a tile with the ids that it has in this map, or null if there is none. Throws
  // Error(kMapDamaged) if it is not coded with the map's codebook.
  std::shared_ptr<const Tile> LoadTile(TileId tile_id) const;
  std::vector<KeyframeRecord> KeyframesOfTile(TileId tile_id) const;

  // Copies sessions and keyframes, and notes the ids that they get.
  void CopySessions(CodebookId codebook_id, MapUpdate* update);
  // Returns a tile with the ids of the merged map. `other` has the ids of links. After
  // CopySessions.
  std::optional<Tile> LoadRenumbered(TileId tile_id, const MergeSource& other) const;

 private:
  std::shared_ptr<const Tile> LoadStored(TileId tile_id) const;  // As LoadTile before any motion.
  std::shared_ptr<const DecodedTile> InOwnCodes(const TileRecord& record) const;

  const MapStore& store_;
  MapSnapshot snapshot_;
  RememberedTiles tiles_;
  std::shared_ptr<const Codebook> codebook_;
  std::optional<Transcoder> transcoder_;
  std::optional<MapMotion> motion_;
  std::unordered_map<LandmarkId, LandmarkId> links_;
  NewIds ids_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_MERGE_SOURCE_H_
