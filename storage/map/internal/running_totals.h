// Keeps the totals of a map up to date during an update; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_RUNNING_TOTALS_H_
#define CAIRN_STORAGE_MAP_INTERNAL_RUNNING_TOTALS_H_

#include <cstdint>
#include <optional>
#include <set>

#include "storage/map/map_store.h"
#include "storage/map/map_versions.h"

namespace cairn {

// Starts from the totals of a version and follows additions and removals, so that the time to
// publish an update does not grow with the map. Only the bounds may require a look at the tiles.
class RunningTotals {
 public:
  explicit RunningTotals(const MapTotals& start) : totals_(start) {}

  void AddSessions(int64_t count) { totals_.num_sessions += count; }    // A negative count removes.
  void AddKeyframes(int64_t count) { totals_.num_keyframes += count; }  // A negative count removes.
  void AddTile(const TileRecord& tile);
  void RemoveTile(const TileRecord& tile);

  // Returns false if the tiles have to be asked for the bounds: an update removed a tile at their
  // edge, or they span more than half of the globe. The bounds then lie within totals().bounds.
  bool KnowsBounds() const { return !are_bounds_open_ && gone_from_edge_.empty(); }
  void SetBounds(const std::optional<GeoBox>& bounds);

  const MapTotals& totals() const { return totals_; }

 private:
  void CountTile(const TileRecord& tile, int64_t sign);

  MapTotals totals_;
  std::set<TileId> gone_from_edge_;
  bool are_bounds_open_ = false;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_RUNNING_TOTALS_H_
