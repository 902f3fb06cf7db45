#include "ingest/tile_changes.h"

namespace cairn {

void TileChanges::Add(const TileChanges& other) {
  num_merged += other.num_merged;
  num_new += other.num_new;
  num_not_needed += other.num_not_needed;
  num_faded += other.num_faded;
  num_evicted += other.num_evicted;
  num_keyframes_replaced += other.num_keyframes_replaced;
  num_bytes_before += other.num_bytes_before;
  num_bytes_after += other.num_bytes_after;
}

}  // namespace cairn
