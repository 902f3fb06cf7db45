// Cells of 4 x 4 tiles: the unit in which tile records are read and cached; private to storage.
// The larger cells of core/cell_name.h divide a map among servers.
#ifndef CAIRN_STORAGE_MAP_TILE_CELLS_H_
#define CAIRN_STORAGE_MAP_TILE_CELLS_H_

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/geodesy.h"
#include "core/tile_id.h"

namespace cairn {

// The value of the id of the cell's south-western tile. Cells are 600 m wide.
enum class TileCell : uint64_t {};

TileCell CellOf(TileId tile_id);

// Returns cells that together hold every tile whose bounding box meets `box`. Returns nothing if
// the box is large, at a pole, or near the border of a UTM zone: such boxes are not cached.
std::optional<std::vector<TileCell>> CellsMeeting(const GeoBox& box);

// Returns the tile ids of the cell as ranges [first, last], one for each column of tiles.
std::vector<std::pair<int64_t, int64_t>> TileRanges(TileCell cell);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_TILE_CELLS_H_
