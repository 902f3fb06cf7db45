// Reads the tiles of the latest version page by page; private to storage. The rules of
// map_queries.h hold.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_TILE_PAGES_H_
#define CAIRN_STORAGE_MAP_INTERNAL_TILE_PAGES_H_

#include <string_view>

#include "storage/database/connection.h"
#include "storage/map/map_store.h"

namespace cairn::queries {

// The SQL of the two searches, for the tests of EXPLAIN QUERY PLAN.
std::string_view TileIdsInBoxSql();
std::string_view TileIdsAfterSql();

// Looks at 5,000 tiles, or at one more than the limit if that is more. If the spatial index finds
// more tiles in the box, goes through the tiles by id instead, and the next page continues there.
TilePage FindTilePage(db::Connection* connection, const TilePageRequest& request, MapVersion as_of);

}  // namespace cairn::queries

#endif  // CAIRN_STORAGE_MAP_INTERNAL_TILE_PAGES_H_
