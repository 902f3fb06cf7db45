#include "ingest/place/known_tiles.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "core/error.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/write_tile.h"
#include "storage/map/describe_tile.h"

namespace cairn {
namespace {

// Tells what a tile without a session is made from.
std::string DigestWithout(const TileRecord& stored, SessionId session_id) {
  return fmt::format("{} without {}", stored.digest, Value(session_id));
}

}  // namespace

KnownTiles::KnownTiles(const MapSnapshot& map, SessionId without,
                       std::shared_ptr<TileMemory> memory)
    : stored_(map, std::move(memory)), without_(without) {
  if (without == SessionId{}) {
    return;
  }
  if (CurrentCodebook() == nullptr) {
    throw Error(ErrorCode::kMapDamaged, "the map has a session, and no codebook");
  }
  for (const TileId tile_id : map.TilesOfSession(without)) {
    if (const std::optional<TileRecord> stored = map.FindTile(tile_id)) {
      Changed& changed = changed_[tile_id];
      changed.stored = *stored;
      const std::shared_ptr<const DecodedTile> known = WithoutIt(*stored);
      if (!IsEmpty(known->tile)) {
        changed.record = DescribeTile(known->tile);
        changed.record->payload_id = stored->payload_id;
        changed.record->digest = DigestWithout(*stored, without);
      }
    }
  }
}

std::shared_ptr<const DecodedTile> KnownTiles::WithoutIt(const TileRecord& stored) const {
  return memory()->Made(DigestWithout(stored, without_), [&] {
    return ReadyForMap(WithoutSession(stored_.Decoded(stored)->tile, without_), *CurrentCodebook());
  });
}

std::shared_ptr<const Tile> KnownTiles::Find(TileId tile_id) const {
  const auto changed = changed_.find(tile_id);
  if (changed == changed_.end()) {
    return stored_.Find(tile_id);
  }
  const std::shared_ptr<const DecodedTile> known = WithoutIt(changed->second.stored);
  return {known, &known->tile};
}

std::vector<TileRecord> KnownTiles::FindTiles(const GeoBox& box) const {
  std::vector<TileRecord> known;
  for (TileRecord& stored : stored_.FindTiles(box)) {
    const auto changed = changed_.find(stored.tile_id);
    if (changed == changed_.end()) {
      known.push_back(std::move(stored));
    } else if (changed->second.record) {
      known.push_back(*changed->second.record);
    }
  }
  return known;
}

StoredTile KnownTiles::LoadTile(const TileRecord& record) const {
  const auto changed = changed_.find(record.tile_id);
  if (changed == changed_.end()) {
    return stored_.LoadTile(record);
  }
  const TileRecord& stored = changed->second.stored;
  StoredTile tile;
  tile.decoded = WithoutIt(stored);
  tile.accuracy = AccuracyOf(SessionsInTile(stored_.Decoded(stored)->tile), stored_.map());
  return tile;
}

}  // namespace cairn
