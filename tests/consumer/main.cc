// Queries an empty map through the installed headers and libraries. The answer must be "no
// coverage".
#include <cstdio>
#include <memory>

#include "core/geodesy.h"
#include "engine/localizer.h"
#include "storage/map/map_store.h"
#include "storage/map/tile_cache.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: consumer NEW_MAP\n");
    return 2;
  }
  auto store = std::make_shared<cairn::MapStore>(cairn::MapStore::Create(argv[1]));
  const cairn::Localizer localizer(store, std::make_shared<cairn::TileCache>(1 << 20),
                                   cairn::LocalizerOptions());
  cairn::LocalizeQuery query;
  query.prior = cairn::PositionPrior{cairn::Geodetic::FromDegrees(47.0, 8.0, 400.0), 10.0, {}};
  const cairn::LocalizeResult result = localizer.Localize(query);
  std::printf("%s\n", cairn::NotLocalizedReasonName(result.reason));
  return result.localized ? 1 : 0;
}
