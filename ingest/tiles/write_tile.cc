#include "ingest/tiles/write_tile.h"

#include "engine/index/inverted_lists.h"
#include "ingest/tiles/tile_edit.h"
#include "storage/map/describe_tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {

bool IsEmpty(const Tile& tile) { return tile.num_landmarks() == 0 || tile.num_keyframes() == 0; }

DecodedTile ReadyForMap(const Tile& tile, const Codebook& codebook) {
  DecodedTile ready;
  ready.tile = PickLandmarks(tile, MortonOrder(tile.x_in_tile));
  if (tile.codebook_id == codebook.id) {
    ready.lists = MakeTileLists(codebook, ready.tile.codes, InvertedListsOptions());
  }
  return ready;
}

EncodedTile EncodeForMap(const Tile& tile, const Codebook& codebook) {
  EncodedTile encoded;
  encoded.record.tile_id = tile.id;
  if (IsEmpty(tile)) {
    return encoded;
  }
  const auto ready = std::make_shared<const DecodedTile>(ReadyForMap(tile, codebook));
  encoded.record = DescribeTile(ready->tile);
  encoded.payload = EncodeTile(ready->tile, ready->lists);
  encoded.decoded = ready;
  return encoded;
}

void PutTile(const EncodedTile& tile, MapUpdate* update) {
  if (tile.payload.empty()) {
    update->RemoveTile(tile.record.tile_id);
  } else {
    update->PutTile(tile.record, tile.payload);
  }
}

int64_t WriteTile(const Tile& tile, const Codebook& codebook, MapUpdate* update) {
  const EncodedTile encoded = EncodeForMap(tile, codebook);
  PutTile(encoded, update);
  return std::ssize(encoded.payload);
}

}  // namespace cairn
