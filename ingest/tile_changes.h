// The fate of landmarks and keyframes when a session or a map joined a tile.
#ifndef CAIRN_INGEST_TILE_CHANGES_H_
#define CAIRN_INGEST_TILE_CHANGES_H_

#include <cstdint>

namespace cairn {

// The newcomer is the session of an ingest or the second map of a merge. A landmark counts once for
// each tile that holds it.
struct TileChanges {
  int64_t num_merged = 0;      // Landmarks of the newcomer that the map knew,
  int64_t num_new = 0;         // that it did not know,
  int64_t num_not_needed = 0;  // and that it did not take, as the newcomer's photos see enough.
  int64_t num_faded = 0;       // Known landmarks that went, since they probably exist no more.
  int64_t num_evicted = 0;     // Landmarks that the selection left out.
  int64_t num_keyframes_replaced = 0;
  int64_t num_bytes_before = 0;
  int64_t num_bytes_after = 0;

  void Add(const TileChanges& other);
};

}  // namespace cairn

#endif  // CAIRN_INGEST_TILE_CHANGES_H_
