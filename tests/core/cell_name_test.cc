#include "core/cell_name.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace cairn {
namespace {

TEST(CellName, IsThatOfTheTileDividedByEight) {
  EXPECT_EQ(CellName(TileId::Parse("32N-03104-35120")), "32N-00388-04390");
  EXPECT_EQ(CellName(TileId::Parse("32N-03111-35127")), "32N-00388-04390");
  EXPECT_EQ(CellName(TileId::Parse("32N-03112-35127")), "32N-00389-04390");
}

TEST(CellName, OfAPositionIsThatOfItsTile) {
  const Geodetic zurich = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  EXPECT_EQ(CellName(zurich), CellName(TileId::Containing(zurich)));
}

TEST(CellName, DiffersBetweenHemispheresAndZones) {
  std::set<std::string> names;
  for (const double lon_deg : {3.0, 9.0}) {
    for (const double lat_deg : {-40.0, 40.0, 88.0}) {
      names.insert(CellName(Geodetic::FromDegrees(lat_deg, lon_deg, 0.0)));
    }
  }
  EXPECT_EQ(names.size(), 6u);
  for (const std::string& name : names) {
    EXPECT_TRUE(IsCellName(name)) << name;
  }
}

TEST(CellName, NothingElseHasItsForm) {
  for (const char* text :
       {"", "32N-00388-0439", "32N-00388-043900", "32X-00388-04390", "32N_00388-04390",
        "32N-00388-0439O", "32n-00388-04390", " 32N-00388-04390", "32N-00388-04390\r\nX: y",
        "3\xC2\xB2-00388-04390"}) {
    EXPECT_FALSE(IsCellName(text)) << text;
  }
  EXPECT_FALSE(IsCellName(std::string("32N-00388-0439\0", 15)));
}

}  // namespace
}  // namespace cairn
