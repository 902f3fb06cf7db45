// Values on the command line as people write them.
#include "cli/arguments.h"

#include <gtest/gtest.h>

#include "cli/recording_time.h"
#include "core/error.h"
#include "support/expect_error.h"

namespace cairn {
namespace {

using testing::ExpectError;

TEST(ParseGeodetic, BlanksDoNotCount) {
  const Geodetic place = ParseGeodetic("--prior", "55.6985, 13.1950 ,\t72");
  EXPECT_NEAR(place.lat_deg(), 55.6985, 1e-9);
  EXPECT_NEAR(place.lon_deg(), 13.195, 1e-9);
  EXPECT_EQ(place.h_m, 72.0);
}

TEST(ParseGeodetic, NamesTheNumbersThatAreMissing) {
  const auto expect = [](const char* text, const char* finding) {
    ExpectError([&] { ParseGeodetic("--origin", text); }, ErrorCode::kInvalidArgument, finding);
  };
  expect("55.6,13.1", "--origin: expected latitude, longitude and height");
  expect("55.6,13.1", "lacks the height");
  expect("55.6,,72", "lacks the longitude");
  expect("55.6", "lacks the longitude and the height");
  expect("55,6,13,1,72", "Write decimals with a point");
  expect("55.6 13.1,8,72", "'55.6 13.1' is not a finite number");
}

TEST(ParsePlace, TheHeightMayBeMissing) {
  const Geodetic place = ParsePlace("--prior", "55.6985, 13.1950");
  EXPECT_NEAR(place.lon_deg(), 13.195, 1e-9);
  EXPECT_EQ(place.h_m, 0.0);
  EXPECT_EQ(ParsePlace("--prior", "55.6985,13.1950,72").h_m, 72.0);
  const auto expect = [](const char* text, const char* finding) {
    ExpectError([&] { ParsePlace("--prior", text); }, ErrorCode::kInvalidArgument, finding);
  };
  expect("55.6", "expected latitude, longitude and, if known, height");
  expect("55.6", "lacks the longitude");
  expect("55.6,13.1,", "lacks the height");
  expect("95.6,13.1", "--prior");
}

TEST(UtcTimeOf, ReadsDatesOffsetsAndFractions) {
  EXPECT_EQ(UtcTimeOf("2026-01-31"), "2026-01-31T00:00:00Z");
  EXPECT_EQ(UtcTimeOf("2026-01-31T12:00:00Z"), "2026-01-31T12:00:00Z");
  EXPECT_EQ(UtcTimeOf("2026-01-31T12:00:00.123Z"), "2026-01-31T12:00:00Z");
  EXPECT_EQ(UtcTimeOf("2026-01-01T00:30:00+01:00"), "2025-12-31T23:30:00Z");
  EXPECT_EQ(UtcTimeOf("2024-02-28T23:30:00.5-00:45"), "2024-02-29T00:15:00Z");
}

TEST(UtcTimeOf, LeavesOtherTextsToTheirRefusal) {
  for (const char* text : {"", "monday", "2026-01-31T12:00:00", "2026-02-30T12:00:00Z",
                           "2026-01-31T12:00:00+1", "2026-01-31T25:00:00Z", "31.1.2026"}) {
    EXPECT_EQ(UtcTimeOf(text), text);
  }
}

}  // namespace
}  // namespace cairn
