// A tile's square as GeoJSON.
#ifndef CAIRN_HTTP_JSON_TILE_SQUARE_H_
#define CAIRN_HTTP_JSON_TILE_SQUARE_H_

#include <nlohmann/json.hpp>

#include "core/tile_id.h"

namespace cairn {

// Returns a Polygon of one closed ring. A square on the antimeridian runs on past 180 degrees.
nlohmann::ordered_json TileSquareJson(TileId tile_id);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_TILE_SQUARE_H_
