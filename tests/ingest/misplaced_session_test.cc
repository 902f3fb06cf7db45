// Tests sessions that stand far from where the map sees them, and sessions that the map cannot
// judge.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/angles.h"
#include "core/error.h"
#include "ingest/ingest_session.h"
#include "ingest/kitti_thirds.h"
#include "support/expect_error.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing::SessionNamed;
using testing::ShortStreet;

testing::StreetWorldOptions OnWednesday() {
  testing::StreetWorldOptions street = ShortStreet();
  street.view_seed = 78;
  return street;
}

// ecef_from_world after a turn about the vertical at the middle of the street, then a shift.
Sim3d Misplaced(const testing::StreetWorld& street, double turn_rad,
                const Eigen::Vector3d& shift_in_enu) {
  const Eigen::Vector3d middle(0.5 * street.options().length_m, 0.0, 0.0);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
  const Rigid3d moved(turn, middle + shift_in_enu - turn * middle);
  const Rigid3d ecef_from_enu = EcefFromEnu(street.options().origin);
  return (ecef_from_enu * moved * ecef_from_enu.Inverse()) * street.EcefFromWorld();
}

class MisplacedSession : public ::testing::Test {
 protected:
  MisplacedSession() : store_(MapStore::Create(dir_.File("map.gpkg"))), wednesday_(OnWednesday()) {
    const testing::StreetWorld monday(ShortStreet());
    IngestOptions options = SessionNamed("monday");
    options.recorded_at = "2026-01-01T00:00:00Z";
    IngestSession(monday.Reconstruct(), monday.EcefFromWorld(), options, &store_, {});
  }

  IngestReport Ingest(const testing::StreetWorld& street, const Sim3d& ecef_from_world,
                      const IngestOptions& options) {
    return IngestSession(street.Reconstruct(), ecef_from_world, options, &store_, {});
  }

  // What the refusal of the session says. The map must stay as it is.
  std::string RefusalOf(const Sim3d& ecef_from_world, const IngestOptions& options) {
    const MapVersion version = store_.Snapshot().version();
    std::string message;
    try {
      const IngestReport report = Ingest(wednesday_, ecef_from_world, options);
      ADD_FAILURE() << "was accepted; the map recognizes " << report.comparison.num_localized
                    << " of " << report.comparison.num_expected << " and "
                    << report.comparison.num_found << " of " << report.comparison.num_sought;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kConflict);
      message = error.what();
    }
    EXPECT_EQ(store_.Snapshot().version(), version);
    return message;
  }

  testing::TempDir dir_;
  MapStore store_;
  testing::StreetWorld wednesday_;
};

TEST_F(MisplacedSession, IsRefusedWithTheShiftHoweverLarge) {
  for (const Eigen::Vector3d& shift_in_enu :
       {Eigen::Vector3d(0, 10, 0), Eigen::Vector3d(25, 0, 0), Eigen::Vector3d(0, -40, 0),
        Eigen::Vector3d(0, 0, 15), Eigen::Vector3d(300, 0, 0)}) {
    const std::string meters = fmt::format("{:.0f}", shift_in_enu.norm());
    EXPECT_THAT(RefusalOf(Misplaced(wednesday_, 0.0, shift_in_enu), SessionNamed("wrong")),
                AllOf(ContainsRegex("sees [0-9]+ of its photos " + meters + "\\.0[0-9] m away"),
                      HasSubstr("max_moved_m"), HasSubstr("--apart")));
  }
}

TEST_F(MisplacedSession, IsRefusedWithItsTurn) {
  EXPECT_THAT(
      RefusalOf(Misplaced(wednesday_, 0.5 * kPi, Eigen::Vector3d::Zero()), SessionNamed("wrong")),
      ContainsRegex("turned by (89\\.9|90\\.[01]) degrees"));
  EXPECT_THAT(RefusalOf(Misplaced(wednesday_, kPi, Eigen::Vector3d::Zero()), SessionNamed("wrong")),
              ContainsRegex("turned by (179\\.9|180\\.0) degrees"));
}

TEST_F(MisplacedSession, FollowsTheMapAsFarAsItsPositionsMayErr) {
  const Eigen::Vector3d shift_in_enu(6.0, -5.0, 4.0);
  IngestOptions phone = SessionNamed("phone");
  phone.agreement.position_accuracy_m = 5.0;
  const IngestReport report = Ingest(wednesday_, Misplaced(wednesday_, 0.0, shift_in_enu), phone);
  EXPECT_NEAR(report.comparison.fit.moved_m, shift_in_enu.norm(), 0.05);
  EXPECT_NEAR(report.comparison.fit.raised_m, -4.0, 0.05);
  EXPECT_GT(report.changes.num_merged, 4 * report.changes.num_new);
  EXPECT_EQ(report.keyframe_answers.num_lost, 0);
}

TEST_F(MisplacedSession, DoesNotFollowTheMapFartherThanItsPositionsErr) {
  IngestOptions survey = SessionNamed("survey");
  survey.agreement.position_accuracy_m = 0.1;
  EXPECT_THAT(RefusalOf(Misplaced(wednesday_, 0.0, Eigen::Vector3d(6.0, -5.0, 4.0)), survey),
              ContainsRegex("sees [0-9]+ of its photos 8\\.[78]"));
}

// Twenty years later, so that landmarks would fade.
TEST_F(MisplacedSession, TakesNothingFromTheMapIfItCannotBeJudged) {
  testing::StreetWorldOptions another = OnWednesday();
  another.seed = 9;
  another.length_m = 18.0;
  IngestOptions few = SessionNamed("few");
  few.recorded_at = "2046-01-01T00:00:00Z";
  const testing::StreetWorld street(another);
  const IngestReport report = Ingest(street, street.EcefFromWorld(), few);
  EXPECT_GT(report.comparison.num_expected, 0);
  EXPECT_FALSE(IsJudged(report.comparison));
  EXPECT_EQ(report.changes.num_faded, 0);
  EXPECT_EQ(report.changes.num_evicted, 0);
  EXPECT_EQ(report.changes.num_keyframes_replaced, 0);
  EXPECT_GT(report.keyframe_answers.num_asked, 10);
  EXPECT_EQ(report.keyframe_answers.num_lost, 0);
}

TEST_F(MisplacedSession, IsRefusedWhereTheMapKnowsThePlaceIfItHasToBeAnchored) {
  testing::StreetWorldOptions another = OnWednesday();
  another.seed = 9;
  another.length_m = 18.0;
  const testing::StreetWorld street(another);
  IngestOptions few = SessionNamed("few");
  few.agreement.unanchored = Unanchored::kRefuse;
  testing::ExpectError([&] { Ingest(street, street.EcefFromWorld(), few); }, ErrorCode::kConflict,
                       "session 'few' is not anchored: the map recognizes 0 of 7 photos");
}

TEST(MisplacedDrive, OfKittiIsRefused) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  testing::KittiThirds drive;
  const Rigid3d ecef_from_enu = EcefFromEnu(drive.place());
  for (const Eigen::Vector3d& shift_in_enu :
       {Eigen::Vector3d(0.0, 10.0, 0.0), Eigen::Vector3d(0.0, 0.0, 20.0)}) {
    Sim3d moved = drive.ecef_from_world();
    moved.translation += ecef_from_enu.rotation * shift_in_enu;
    try {
      IngestSession(drive.Third(1), moved, SessionNamed("wrong"), drive.store(), {});
      FAIL() << "was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kConflict);
      EXPECT_THAT(error.what(), HasSubstr("contradicts the map: the map sees"));
    }
  }
}

}  // namespace
}  // namespace cairn
