#include "engine/tiles/tiles_options.h"

#include "core/require.h"

namespace cairn {

void TilesOptions::Validate() const {
  RequireWithin("tiles.max_tiles", max_tiles, 1, 10'000);
  RequireWithin("tiles.height_margin_m", height_margin_m, 0.0, 1e4);
  RequireWithin("tiles.deadline_share", deadline_share, 0.0, 1.0);
}

}  // namespace cairn
