// The tiles that an ingest or a merge uses, each decoded once and indexed once. Private to ingest.
#ifndef CAIRN_INGEST_PLACE_TILE_MEMORY_H_
#define CAIRN_INGEST_PLACE_TILE_MEMORY_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/loading_cache.h"
#include "engine/tiles/map_tiles.h"
#include "engine/tiles/tile_cache.h"
#include "storage/map/map_store.h"
#include "storage/tile/decoded_tile.h"

namespace cairn {

// The steps of an ingest share one memory, so that none decodes or indexes what another one did.
// Bounded in bytes: a tile that has given way is decoded again. Keys are digests, so one memory
// serves several maps whose codebooks are equal. Safe to use from any thread.
class TileMemory {
 public:
  TileMemory();

  // Returns the tile of the digest. Decodes what `load` returns if the memory does not have it.
  // Throws what `load` and DecodePayload throw.
  std::shared_ptr<const DecodedTile> Decoded(const std::string& digest,
                                             const std::function<LargeVector<uint8_t>()>& load);
  // Returns the tile that `make` makes from tiles of the memory. `digest` has to tell what it is
  // made from.
  std::shared_ptr<const DecodedTile> Made(const std::string& digest,
                                          const std::function<DecodedTile()>& make);
  // Keeps what the payload decodes to, which is thereby not decoded.
  void Keep(std::span<const uint8_t> payload, std::shared_ptr<const DecodedTile> decoded);

  // The cache of all localizers that ask these tiles. Indexes tiles as LocalizerOptions() says.
  const std::shared_ptr<TileCache>& searchable() const { return searchable_; }

  // Number of payloads that were decoded so far.
  int64_t num_decoded() const { return num_decoded_; }

 private:
  LoadingCache<DecodedTile> decoded_;
  std::atomic<int64_t> num_decoded_ = 0;
  const std::shared_ptr<TileCache> searchable_;
};

// A version of a map, read through a memory. Calls throw as those of MapSnapshot, and
// Error(kMapDamaged) if a tile does not decode. Safe to call from any thread.
class RememberedTiles : public MapTiles {
 public:
  // `map` must outlive the object.
  RememberedTiles(const MapSnapshot& map, std::shared_ptr<TileMemory> memory)
      : map_(map), memory_(std::move(memory)) {}

  const MapSnapshot& map() const { return map_; }
  const std::shared_ptr<TileMemory>& memory() const { return memory_; }
  // Returns a tile that FindTiles or the map returned.
  std::shared_ptr<const DecodedTile> Decoded(const TileRecord& record) const;
  // Returns the tile, or null if the map has none.
  std::shared_ptr<const Tile> Find(TileId tile_id) const;

  std::shared_ptr<const Codebook> CurrentCodebook() const override {
    return map_.CurrentCodebook();
  }
  std::vector<TileRecord> FindTiles(const GeoBox& box) const override {
    return map_.FindTiles(box);
  }
  StoredTile LoadTile(const TileRecord& record) const override;

 private:
  const MapSnapshot& map_;
  std::shared_ptr<TileMemory> memory_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_TILE_MEMORY_H_
