#include "ingest/tiles/write_tile.h"

#include "engine/index/inverted_lists.h"
#include "ingest/tiles/tile_edit.h"
#include "storage/map/describe_tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {

EncodedTile EncodeForMap(const Tile& tile, const Codebook& codebook) {
  EncodedTile encoded;
  encoded.record.tile_id = tile.id;
  if (tile.num_landmarks() == 0 || tile.num_keyframes() == 0) {
    return encoded;
  }
  const Tile ordered = PickLandmarks(tile, MortonOrder(tile.x_in_tile));
  const TileLists lists = ordered.codebook_id == codebook.id
                              ? MakeTileLists(codebook, ordered.codes, InvertedListsOptions())
                              : TileLists();
  encoded.record = DescribeTile(ordered);
  encoded.payload = EncodeTile(ordered, lists);
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
