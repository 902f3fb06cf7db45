// GeoJSON files for --region, and whether squares meet the region.
#include "cli/geojson_region.h"
#include "core/error.h"
#include "core/tile_id.h"
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  const std::string path =
      cairn::testing::WriteFuzzFile("region.geojson", cairn::testing::AsText(data, size));
  try {
    const GeoRegion region = ReadGeoJsonRegion(path);
    CAIRN_CHECK(!region.boxes().empty(), "a region without boxes");
    for (const double lat_deg : {-89.9, 0.0, 49.0, 89.9}) {
      region.Meets(TileId::Containing(Geodetic::FromDegrees(lat_deg, 8.4, 0.0)));
    }
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput, error.what());
  }
  return 0;
}
