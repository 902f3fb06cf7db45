// A temporary map, deleted with the object. Private to ingest.
#ifndef CAIRN_INGEST_SCRATCH_MAP_H_
#define CAIRN_INGEST_SCRATCH_MAP_H_

#include <memory>
#include <vector>

#include "core/tile_id.h"
#include "storage/map/map_store.h"

namespace cairn {

class ScratchMap {
 public:
  // Makes an empty map in a new folder beside the temporary files.
  ScratchMap();
  ScratchMap(ScratchMap&&) noexcept;
  ~ScratchMap();

  MapStore& store() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// These tiles of the map without the session `without`. The engine can ask it what the map says
// about a session that the map holds already.
ScratchMap MapWithoutSession(const std::vector<TileId>& tiles, SessionId without,
                             const MapSnapshot& map);

}  // namespace cairn

#endif  // CAIRN_INGEST_SCRATCH_MAP_H_
