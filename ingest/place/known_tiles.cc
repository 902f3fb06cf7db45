#include "ingest/place/known_tiles.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/write_tile.h"
#include "storage/map/describe_tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// Some kilometers of streets. A tile that has given way is decoded again.
constexpr size_t kDecodedBytes = size_t{256} << 20;

bool IsEmpty(const Tile& tile) { return tile.num_landmarks() == 0 || tile.num_keyframes() == 0; }

}  // namespace

KnownTiles::KnownTiles(const MapSnapshot& map, SessionId without)
    : map_(map), stored_(map), without_(without), decoded_(kDecodedBytes) {
  if (without != SessionId{}) {
    const std::vector<TileId> tiles = map.TilesOfSession(without);
    changed_.insert(tiles.begin(), tiles.end());
  }
}

std::shared_ptr<const KnownTiles::Known> KnownTiles::Decoded(const TileRecord& stored) const {
  return decoded_.GetOrLoad(stored.digest, [&] {
    Known known;
    known.tile = DecodeTile(map_.LoadPayload(stored.payload_id));
    if (HasChanged(stored.tile_id)) {
      known.tile = WithoutSession(std::move(known.tile), without_);
      if (!IsEmpty(known.tile)) {
        known.record = DescribeTile(known.tile);
        known.record->payload_id = stored.payload_id;
        known.record->digest = stored.digest;  // Of what the tile is made from.
      }
    }
    return std::make_shared<const Known>(std::move(known));
  });
}

std::shared_ptr<const Tile> KnownTiles::Find(TileId tile_id) const {
  const std::optional<TileRecord> record = map_.FindTile(tile_id);
  if (!record) {
    return nullptr;
  }
  const std::shared_ptr<const Known> known = Decoded(*record);
  return {known, &known->tile};
}

std::vector<TileRecord> KnownTiles::FindTiles(const GeoBox& box) const {
  std::vector<TileRecord> known;
  for (TileRecord& stored : map_.FindTiles(box)) {
    if (!HasChanged(stored.tile_id)) {
      known.push_back(std::move(stored));
      continue;
    }
    const std::shared_ptr<const Known> decoded = Decoded(stored);
    if (decoded->record) {
      known.push_back(*decoded->record);
    }
  }
  return known;
}

StoredTile KnownTiles::LoadTile(const TileRecord& record) const {
  StoredTile tile = stored_.LoadTile(record);
  if (HasChanged(record.tile_id)) {
    const std::vector<uint8_t> payload =
        EncodeForMap(Decoded(record)->tile, *CurrentCodebook()).payload;
    tile.payload.assign(payload.begin(), payload.end());
  }
  return tile;
}

}  // namespace cairn
