#include "ingest/place/position_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

// A walk to the north-east in Lund, at 36 to 38 m.
std::vector<CameraPosition> WalkInLund(int count = 12) {
  std::vector<CameraPosition> positions;
  for (int i = 0; i < count; ++i) {
    positions.push_back({std::to_string(i) + ".jpg",
                         Geodetic::FromDegrees(55.6985123 + 1.37e-5 * i, 13.1950457 + 2.11e-5 * i,
                                               36.0 + 0.17 * i)});
  }
  return positions;
}

std::string RefusalOf(std::vector<CameraPosition> positions,
                      const std::optional<double>& height_m = {}) {
  try {
    CheckPositions(height_m, &positions);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    return e.what();
  }
  return "no error";
}

TEST(CheckPositions, LeavesGoodOnesAlone) {
  std::vector<CameraPosition> positions = WalkInLund();
  const PositionFindings findings = CheckPositions({}, &positions);
  EXPECT_EQ(positions.size(), 12u);
  EXPECT_EQ(findings.num_at_null_island, 0);
  EXPECT_EQ(findings.num_without_height, 0);
  for (const CameraPosition& position : positions) {
    EXPECT_TRUE(position.has_height);
  }
}

TEST(CheckPositions, LeavesOutThoseAtNullIsland) {
  std::vector<CameraPosition> positions = WalkInLund();
  positions[2].position = Geodetic::FromDegrees(0.0, 0.0, 0.0);
  positions[7].position = Geodetic::FromDegrees(1e-6, -1e-6, 30.0);
  EXPECT_EQ(CheckPositions({}, &positions).num_at_null_island, 2);
  EXPECT_EQ(positions.size(), 10u);
}

TEST(CheckPositions, AHeightOfZeroIsNoneFarFromTheOthers) {
  std::vector<CameraPosition> positions = WalkInLund();
  for (size_t i = 0; i < positions.size(); i += 2) {
    positions[i].position.h_m = 0.0;
  }
  EXPECT_EQ(CheckPositions({}, &positions).num_without_height, 6);
  for (size_t i = 0; i < positions.size(); ++i) {
    EXPECT_EQ(positions[i].has_height, i % 2 == 1);
    EXPECT_NEAR(positions[i].position.h_m, 37.0, 1.1);
  }
}

TEST(CheckPositions, AHeightThatNoPlaceHasIsNone) {
  std::vector<CameraPosition> positions = WalkInLund();
  positions[0].position.h_m = -9999.0;
  positions[5].position.h_m = 32767.0;
  const PositionFindings findings = CheckPositions({}, &positions);
  EXPECT_EQ(findings.num_without_height, 2);
  EXPECT_THAT(NotesOnPositions(findings).at(0), HasSubstr("2 positions have no height"));
  EXPECT_FALSE(positions[0].has_height || positions[5].has_height);
  EXPECT_NEAR(positions[0].position.h_m, 37.0, 1.1);
  for (CameraPosition& position : positions) {
    position.position.h_m = -9999.0;
    position.has_height = true;
  }
  EXPECT_THAT(RefusalOf(positions), HasSubstr("heights below -500 m or above 10000 m"));
}

TEST(CheckPositions, AConstantHeightIsAHeight) {
  std::vector<CameraPosition> positions = WalkInLund();
  for (CameraPosition& position : positions) {
    position.position.h_m = 37.0;
  }
  EXPECT_EQ(CheckPositions({}, &positions).num_without_height, 0);
}

// The height of the cameras has the reference of --height, not that of the table's column.
TEST(CheckPositions, AStatedHeightHasNoReferenceOfTheTable) {
  std::vector<CameraPosition> positions = WalkInLund();
  for (CameraPosition& position : positions) {
    position.position.h_m = 0.0;
    position.height_reference = HeightReference::kMeanSeaLevel;
  }
  CheckPositions(72.0, &positions);
  EXPECT_EQ(positions[0].position.h_m, 72.0);
  EXPECT_EQ(positions[0].height_reference, std::nullopt);
}

TEST(CheckPositions, AHeightOfZeroIsAHeightAtTheCoast) {
  std::vector<CameraPosition> positions = WalkInLund();
  for (size_t i = 0; i < positions.size(); ++i) {
    positions[i].position.h_m = static_cast<double>(i % 4) - 2.0;
  }
  EXPECT_EQ(CheckPositions({}, &positions).num_without_height, 0);
}

TEST(CheckPositions, WithoutAnyHeightTheHeightHasToBeStated) {
  std::vector<CameraPosition> positions = WalkInLund();
  for (CameraPosition& position : positions) {
    position.position.h_m = 0.0;
  }
  EXPECT_THAT(RefusalOf(positions), HasSubstr("--camera-height"));
  EXPECT_EQ(CheckPositions(41.5, &positions).num_without_height, 12);
  for (const CameraPosition& position : positions) {
    EXPECT_EQ(position.position.h_m, 41.5);
    EXPECT_TRUE(position.has_height);
  }
}

TEST(CheckPositions, RefusesOnePositionForAll) {
  std::vector<CameraPosition> positions = WalkInLund();
  for (CameraPosition& position : positions) {
    position.position = positions[0].position;
  }
  EXPECT_THAT(RefusalOf(positions), HasSubstr("all 12 positions are the same"));
}

TEST(CheckPositions, RefusesCoarseRoundingUnlessTheAccuracySaysSo) {
  std::vector<CameraPosition> positions = WalkInLund();
  for (CameraPosition& position : positions) {
    position.position =
        Geodetic::FromDegrees(std::round(position.position.lat_deg() * 1e3) / 1e3,
                              std::round(position.position.lon_deg() * 1e3) / 1e3, 37.0);
  }
  positions.back().position = Geodetic::FromDegrees(55.7, 13.2, 37.0);
  EXPECT_THAT(RefusalOf(positions), HasSubstr("rounded to 0.001 degrees"));
  for (CameraPosition& position : positions) {
    position.accuracy_m = 60.0;
  }
  EXPECT_EQ(RefusalOf(positions), "no error");
}

TEST(CompareWithExif, RefusesExchangedColumnsAndNotesAnotherTown) {
  const std::vector<CameraPosition> exif = WalkInLund();
  EXPECT_FALSE(CompareWithExif("t.csv", exif, exif));
  std::vector<CameraPosition> elsewhere = exif, exchanged = exif, at_null_island = exif;
  for (size_t i = 0; i < exif.size(); ++i) {
    const Geodetic& position = exif[i].position;
    elsewhere[i].position = Geodetic::FromDegrees(position.lat_deg() + 1.0, position.lon_deg(), 0);
    exchanged[i].position = Geodetic{position.lon_rad, position.lat_rad, 0.0};
    at_null_island[i].position = Geodetic{0.0, 0.0, 0.0};
  }
  const auto note = CompareWithExif("t.csv", elsewhere, exif);
  ASSERT_TRUE(note);
  EXPECT_THAT(*note, HasSubstr("111.3 km from those in the EXIF of the photos; the table counts"));
  EXPECT_THROW(CompareWithExif("t.csv", exchanged, exif), Error);
  EXPECT_FALSE(CompareWithExif("t.csv", exif, at_null_island));
  EXPECT_FALSE(CompareWithExif("t.csv", exif, {exchanged[0], exchanged[1]}));
  // Tokyo's longitude is no latitude.
  std::vector<CameraPosition> in_tokyo = exif;
  for (CameraPosition& position : in_tokyo) {
    position.position = Geodetic::FromDegrees(35.68, 139.77, 40.0);
  }
  EXPECT_TRUE(CompareWithExif("t.csv", in_tokyo, exif));
}

// A map of Lund, and nothing elsewhere.
bool IsInLund(const Geodetic& place) {
  return std::abs(place.lat_deg() - 55.7) < 0.1 && std::abs(place.lon_deg() - 13.2) < 0.1;
}

TEST(RequireNotExchanged, RefusesWhatIsInTheMapTheOtherWayRound) {
  std::vector<CameraPosition> positions = WalkInLund();
  EXPECT_NO_THROW(RequireNotExchanged(positions, IsInLund));
  for (CameraPosition& position : positions) {
    std::swap(position.position.lat_rad, position.position.lon_rad);
  }
  try {
    RequireNotExchanged(positions, IsInLund);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(), HasSubstr("around 13.1952, 55.6986 the map has nothing"));
  }
  EXPECT_NO_THROW(RequireNotExchanged(positions, [](const Geodetic&) { return false; }));
}

// Latitudes beyond the poles do not exist.
TEST(RequireNotExchanged, TakesAnyLongitude) {
  const std::vector<CameraPosition> tokyo = {{"1.jpg", Geodetic::FromDegrees(35.68, 139.77, 40.0)}};
  EXPECT_NO_THROW(RequireNotExchanged(tokyo, IsInLund));
}

}  // namespace
}  // namespace cairn
