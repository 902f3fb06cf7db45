#include "ingest/tile_names.h"

#include <fmt/format.h>

#include <algorithm>

namespace cairn {

std::string TileNames(const std::vector<TileId>& tiles) {
  constexpr size_t kMaxNames = 20;
  std::vector<std::string> names;
  for (const TileId tile_id : tiles) {
    names.push_back(tile_id.ToString());
  }
  const size_t num_left = names.size() - std::min(names.size(), kMaxNames);
  names.resize(names.size() - num_left);
  return fmt::format("{}{}", fmt::join(names, ", "),
                     num_left > 0 ? fmt::format(" and {} more", num_left) : "");
}

}  // namespace cairn
