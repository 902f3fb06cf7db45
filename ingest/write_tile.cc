#include "ingest/write_tile.h"

#include <vector>

#include "engine/index/inverted_lists.h"
#include "ingest/tiling/tile_edit.h"
#include "storage/map/describe_tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {

int64_t WriteTile(const Tile& tile, const Codebook& codebook, MapUpdate* update) {
  if (tile.num_landmarks() == 0 || tile.num_keyframes() == 0) {
    update->RemoveTile(tile.id);
    return 0;
  }
  const Tile ordered = PickLandmarks(tile, MortonOrder(tile.x_in_tile));
  const TileLists lists = ordered.codebook_id == codebook.id
                              ? MakeTileLists(codebook, ordered.codes, InvertedListsOptions())
                              : TileLists();
  const std::vector<uint8_t> payload = EncodeTile(ordered, lists);
  update->PutTile(DescribeTile(ordered), payload);
  return static_cast<int64_t>(payload.size());
}

}  // namespace cairn
