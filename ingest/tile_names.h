// Names of tiles in messages; private to ingest.
#ifndef CAIRN_INGEST_TILE_NAMES_H_
#define CAIRN_INGEST_TILE_NAMES_H_

#include <string>
#include <vector>

#include "core/tile_id.h"

namespace cairn {

// "32N-03104-35120, 32N-03104-35121 and 7 more": at most twenty names.
std::string TileNames(const std::vector<TileId>& tiles);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILE_NAMES_H_
