// Tests sessions that do not stand where the map sees them: moved, resized, refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/angles.h"
#include "core/error.h"
#include "ingest/ingest_session.h"
#include "support/map_builder.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using testing::ErrorCodeOf;
using ::testing::HasSubstr;
using testing::SessionNamed;
using testing::ShortStreet;

// The short street on another day.
testing::StreetWorldOptions OnTuesday() {
  testing::StreetWorldOptions street = ShortStreet();
  street.view_seed = 77;
  return street;
}

// The session in a mirror that stands in the middle of the street. `normal_in_enu` is perpendicular
// to the mirror. Photos are mirrored as well, so the session is consistent.
Reconstruction Mirrored(Reconstruction session, const testing::StreetWorld& street,
                        const Eigen::Vector3d& normal_in_enu) {
  const Sim3d& world_from_enu = street.options().world_from_enu;
  const Eigen::Vector3d middle_in_world =
      world_from_enu * Eigen::Vector3d(0.5 * street.options().length_m, 0.0, 0.0);
  const Eigen::Vector3d normal = world_from_enu.rotation * normal_in_enu;
  const Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity() - 2.0 * normal * normal.transpose();
  const auto reflect = [&](const Eigen::Vector3d& x_in_world) -> Eigen::Vector3d {
    return middle_in_world + mirror * (x_in_world - middle_in_world);
  };
  const Eigen::Matrix3d flip = Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal();
  for (ReconImage& image : session.images) {
    const Eigen::Vector3d center_in_world = reflect(image.cam_from_world.Inverse().translation);
    const Eigen::Quaterniond cam_from_world(
        Eigen::Matrix3d(flip * image.cam_from_world.rotation.toRotationMatrix() * mirror));
    image.cam_from_world = {cam_from_world, -(cam_from_world * center_in_world)};
    for (Keypoint& keypoint : image.features.keypoints) {
      keypoint.x_px = static_cast<float>(street.camera().width_px()) - keypoint.x_px;
      keypoint.orientation_rad = static_cast<float>(WrapAngleRad(kPi - keypoint.orientation_rad));
    }
  }
  for (ReconLandmark& landmark : session.landmarks) {
    landmark.x_in_world = reflect(landmark.x_in_world);
  }
  return session;
}

class SessionDisagreement : public ::testing::Test {
 protected:
  SessionDisagreement() : store_(MapStore::Create(dir_.File("map.gpkg"))) {
    Ingest(testing::StreetWorld(ShortStreet()), "monday");
  }

  IngestReport Ingest(const testing::StreetWorld& world, const std::string& name) {
    return IngestSession(world.Reconstruct(), world.EcefFromWorld(), SessionNamed(name), &store_,
                         {});
  }

  // What the refusal of the session says. The map must stay as it is.
  std::string RefusalOf(const Reconstruction& session, const Sim3d& ecef_from_world) {
    const MapVersion version = store_.Snapshot().version();
    std::string message;
    try {
      const IngestReport report =
          IngestSession(session, ecef_from_world, SessionNamed("wrong"), &store_, {});
      ADD_FAILURE() << "was accepted; the map recognizes " << report.comparison.num_localized
                    << " of " << report.comparison.num_expected;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kConflict);
      message = error.what();
    }
    EXPECT_EQ(store_.Snapshot().version(), version);
    EXPECT_THAT(message,
                AllOf(HasSubstr("session 'wrong' contradicts the map"), HasSubstr("--apart")));
    return message;
  }

  testing::TempDir dir_;
  MapStore store_;
};

TEST_F(SessionDisagreement, AMovedSessionIsBroughtToTheMap) {
  const testing::StreetWorld tuesday(OnTuesday());
  Sim3d moved = tuesday.EcefFromWorld();
  moved.translation +=
      EcefFromEnu(tuesday.options().origin).rotation * Eigen::Vector3d(1.0, 0.5, 0);
  const IngestReport report =
      IngestSession(tuesday.Reconstruct(), moved, SessionNamed("tuesday"), &store_, {});
  EXPECT_NEAR(report.comparison.fit.moved_m, std::hypot(1.0, 0.5), 0.05);
  EXPECT_GT(report.changes.num_merged, 4 * report.changes.num_new);
}

TEST_F(SessionDisagreement, ASessionOfAnotherSizeTakesTheSizeOfTheMap) {
  const testing::StreetWorld world(OnTuesday());
  const Reconstruction tuesday = world.Reconstruct();
  Sim3d larger = world.EcefFromWorld();
  larger.scale *= 1.03;
  const IngestReport report = IngestSession(tuesday, larger, SessionNamed("tuesday"), &store_, {});
  EXPECT_NEAR(report.comparison.fit.scale, 1.0 / 1.03, 0.002);
  EXPECT_GT(report.changes.num_merged, 4 * report.changes.num_new);
  const MapSnapshot map = store_.Snapshot();
  for (const KeyframeRecord& keyframe : map.KeyframesOfSession(map.FindSession("tuesday")->id)) {
    const auto image = std::find_if(
        tuesday.images.begin(), tuesday.images.end(),
        [&](const ReconImage& candidate) { return candidate.name == keyframe.image_name; });
    const Rigid3d truth = CamFromTarget(image->cam_from_world, world.EcefFromWorld());
    EXPECT_LT((keyframe.cam_from_ecef.Inverse().translation - truth.Inverse().translation).norm(),
              0.1);
  }
}

TEST_F(SessionDisagreement, AShiftOfFiveMetersIsRefusedWithTheShift) {
  const testing::StreetWorld tuesday(OnTuesday());
  Sim3d moved = tuesday.EcefFromWorld();
  moved.translation += EcefFromEnu(tuesday.options().origin).rotation * Eigen::Vector3d(3, 4, 0);
  EXPECT_THAT(RefusalOf(tuesday.Reconstruct(), moved),
              ContainsRegex("sees 1[0-9] of its photos (4\\.9|5\\.0)[0-9] m away, turned by "
                            "0\\.[0-9] degrees and (0\\.99|1\\.00)[0-9] times as large"));
  IngestOptions apart = SessionNamed("wrong");
  apart.joining = SessionJoining::kApart;
  EXPECT_NO_THROW(IngestSession(tuesday.Reconstruct(), moved, apart, &store_, {}));
}

TEST_F(SessionDisagreement, ASizeOfElevenTenthsIsRefusedWithTheSize) {
  const testing::StreetWorld tuesday(OnTuesday());
  Sim3d larger = tuesday.EcefFromWorld();
  larger.scale *= 1.1;  // About the origin of the world frame, which is near the street.
  EXPECT_THAT(RefusalOf(tuesday.Reconstruct(), larger),
              ContainsRegex("sees 1[0-9] of its photos .* m away.* 0\\.9[01][0-9] times as large"));
}

TEST_F(SessionDisagreement, AnotherStreetInTheSamePlaceIsRefused) {
  testing::StreetWorldOptions another = OnTuesday();
  another.seed = 9;
  const testing::StreetWorld street(another);
  EXPECT_THAT(RefusalOf(street.Reconstruct(), street.EcefFromWorld()),
              HasSubstr("of 16 photos that stand where the map has photos that look the same way, "
                        "it recognizes 0"));
}

TEST_F(SessionDisagreement, AMirroredStreetIsRefused) {
  // The map knows the street in both directions, as a mirrored session looks back.
  testing::StreetWorldOptions back = ShortStreet();
  back.view_seed = 5;
  back.heading_rad = kPi;
  Ingest(testing::StreetWorld(back), "back");
  const testing::StreetWorld tuesday(OnTuesday());
  for (const Eigen::Vector3d& normal_in_enu :
       {Eigen::Vector3d::UnitX().eval(), Eigen::Vector3d::UnitY().eval()}) {
    // The engine finds poses for most of these photos; no motion of the session explains them.
    EXPECT_THAT(
        RefusalOf(Mirrored(tuesday.Reconstruct(), tuesday, normal_in_enu), tuesday.EcefFromWorld()),
        ContainsRegex("recognizes 1[0-9] of 16 photos, but only [0-2] of them in places that one "
                      "motion|sees [0-9] of its photos 1[0-9]\\.[0-9]+ m away"));
  }
}

// Of a long street, more photos agree with each other, and positions of phones allow more motion.
TEST(MirroredSession, IsRefusedHoweverInaccurateItsPositions) {
  testing::StreetWorldOptions forth = ShortStreet();
  forth.length_m = 150.0;
  forth.num_landmarks = 2600;
  testing::StreetWorldOptions back = forth;
  back.view_seed = 5;
  back.heading_rad = kPi;
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("map.gpkg"));
  const testing::StreetWorld monday(forth), evening(back);
  IngestSession(monday.Reconstruct(), monday.EcefFromWorld(), SessionNamed("forth"), &store, {});
  IngestSession(evening.Reconstruct(), evening.EcefFromWorld(), SessionNamed("back"), &store, {});
  forth.view_seed = 77;
  const testing::StreetWorld tuesday(forth);
  IngestOptions phone = SessionNamed("mirrored");
  phone.agreement.position_accuracy_m = 15.0;
  for (const Eigen::Vector3d& normal_in_enu :
       {Eigen::Vector3d::UnitX().eval(), Eigen::Vector3d::UnitY().eval()}) {
    EXPECT_EQ(ErrorCodeOf([&] {
                IngestSession(Mirrored(tuesday.Reconstruct(), tuesday, normal_in_enu),
                              tuesday.EcefFromWorld(), phone, &store, {});
              }),
              ErrorCode::kConflict);
  }
}

TEST_F(SessionDisagreement, AFewForeignPhotosAreAcceptedAndNotJudged) {
  testing::StreetWorldOptions another = OnTuesday();
  another.seed = 9;
  another.length_m = 12.0;
  const IngestReport report = Ingest(testing::StreetWorld(another), "few");
  EXPECT_EQ(report.comparison.num_expected, 5);
  EXPECT_FALSE(IsJudged(report.comparison));
}

TEST_F(SessionDisagreement, TheSameReconstructionUnderAnotherNameIsNoticed) {
  EXPECT_EQ(ErrorCodeOf([&] { Ingest(testing::StreetWorld(ShortStreet()), "tuesday"); }),
            ErrorCode::kConflict);
}

TEST_F(SessionDisagreement, OtherDescriptorsThanTheMapHasAreRefused) {
  const std::string digest = store_.Snapshot().AllTiles(1)[0].digest;
  testing::StreetWorldOptions street = ShortStreet();
  street.descriptor_dim = 64;
  try {
    Ingest(testing::StreetWorld(street), "second");
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    EXPECT_THAT(e.what(), AllOf(HasSubstr("64-D"), HasSubstr("128-D")));
  }
  EXPECT_EQ(store_.Snapshot().AllTiles(1)[0].digest, digest);
}

}  // namespace
}  // namespace cairn
