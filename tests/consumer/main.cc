// Queries an empty map through the installed headers and libraries. The answer must be "no
// coverage".
#include <cairn/core/geodesy.h>
#include <cairn/engine/localizer.h>
#include <cairn/storage/map/map_store.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: consumer NEW_MAP\n");
    return 2;
  }
  cairn::MapStore::Create(argv[1]);
  const cairn::Localizer localizer = cairn::Localizer::Open(argv[1]);
  cairn::LocalizeQuery query;
  query.prior = cairn::PositionPrior{cairn::Geodetic::FromDegrees(47.0, 8.0, 400.0), 10.0, {}};
  const cairn::LocalizeResult result = localizer.Localize(query);
  std::printf("%s\n", cairn::NotLocalizedReasonName(result.reason));
  return result.localized ? 1 : 0;
}
