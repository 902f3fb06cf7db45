#include "core/cell_name.h"

#include <fmt/format.h>

#include <algorithm>

namespace cairn {

std::string CellName(TileId tile_id) {
  return fmt::format("{:02}{}-{:05}-{:05}", tile_id.zone(), tile_id.north() ? 'N' : 'S',
                     tile_id.easting_idx() / kCellSideTiles,
                     tile_id.northing_idx() / kCellSideTiles);
}

std::string CellName(const Geodetic& position) { return CellName(TileId::Containing(position)); }

bool IsCellName(std::string_view text) {
  constexpr std::string_view kForm = "00N-00000-00000";  // 0 stands for any digit, N also for S.
  const auto fits = [](char form, char c) {
    switch (form) {
      case '0':
        return '0' <= c && c <= '9';
      case 'N':
        return c == 'N' || c == 'S';
      default:
        return c == form;
    }
  };
  return text.size() == kForm.size() && std::equal(kForm.begin(), kForm.end(), text.begin(), fits);
}

}  // namespace cairn
