// Names of cells, by which a front divides queries among servers.
#ifndef CAIRN_CORE_CELL_NAME_H_
#define CAIRN_CORE_CELL_NAME_H_

#include <string>
#include <string_view>

#include "core/tile_id.h"

namespace cairn {

// The HTTP header that carries the name of a cell, in requests and in responses.
inline constexpr char kCellHeader[] = "X-Cairn-Cell";

// A cell is a square of 8 x 8 tiles (1.2 km) in the tile grid. Queries of one cell need nearly the
// same tiles, so the server that gets all of them answers from its cache. A city has many cells,
// and few queries meet the tiles of two cells.
inline constexpr int kCellSideTiles = 8;

// Returns the name of the cell that contains the tile: zone, hemisphere, and the tile's indices
// divided by 8, as in "32N-00388-04390".
std::string CellName(TileId tile_id);

// Returns the name of the cell that contains the position. Throws as TileId::Containing.
std::string CellName(const Geodetic& position);

// Whether the text has the form of a name. Names that come from outside are untrusted; check a name
// before you send it on.
bool IsCellName(std::string_view text);

}  // namespace cairn

#endif  // CAIRN_CORE_CELL_NAME_H_
