// Tests sessions of which a part stands elsewhere, and sessions beyond the map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <utility>
#include <vector>

#include "core/frames.h"
#include "core/geodesy.h"
#include "ingest/ingest_session.h"
#include "ingest/kitti_thirds.h"
#include "ingest/session_refused.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::SessionNamed;
using testing::ShortStreet;
using ::testing::ThrowsMessage;

testing::StreetWorldOptions OnTuesday() {
  testing::StreetWorldOptions street = ShortStreet();
  street.view_seed = 79;
  return street;
}

// Moves the images from this one on, with what they see. A landmark that others see, too, becomes
// two.
Reconstruction WithPartMoved(Reconstruction session, int first_image_idx,
                             const Eigen::Vector3d& shift_in_world) {
  for (size_t i = static_cast<size_t>(first_image_idx); i < session.images.size(); ++i) {
    Rigid3d& cam_from_world = session.images[i].cam_from_world;
    cam_from_world.translation -= cam_from_world.rotation * shift_in_world;
  }
  std::vector<ReconLandmark> landmarks;
  for (const ReconLandmark& landmark : session.landmarks) {
    ReconLandmark rest = {landmark.x_in_world, {}};
    ReconLandmark moved = {landmark.x_in_world + shift_in_world, {}};
    for (const ReconObservation& seen : landmark.observations) {
      (seen.image_idx < first_image_idx ? rest : moved).observations.push_back(seen);
    }
    for (ReconLandmark& part : {std::ref(rest), std::ref(moved)}) {
      if (part.observations.size() >= 2) {
        landmarks.push_back(std::move(part));
      }
    }
  }
  session.landmarks = std::move(landmarks);
  return session;
}

Eigen::Vector3d InWorld(const Sim3d& ecef_from_world, const Geodetic& there,
                        const Eigen::Vector3d& shift_in_enu) {
  return ecef_from_world.rotation.conjugate() * (EcefFromEnu(there).rotation * shift_in_enu) /
         ecef_from_world.scale;
}

class MisplacedPart : public ::testing::Test {
 protected:
  MisplacedPart() : store_(MapStore::Create(dir_.File("map.gpkg"))) {
    const testing::StreetWorld monday(ShortStreet());
    IngestSession(monday.Reconstruct(), monday.EcefFromWorld(), SessionNamed("monday"), &store_,
                  {});
  }

  IngestReport IngestWithPartMoved(int first_image_idx, const Eigen::Vector3d& shift_in_enu) {
    const testing::StreetWorld tuesday(OnTuesday());
    const Eigen::Vector3d shift =
        InWorld(tuesday.EcefFromWorld(), tuesday.options().origin, shift_in_enu);
    return IngestSession(WithPartMoved(tuesday.Reconstruct(), first_image_idx, shift),
                         tuesday.EcefFromWorld(), SessionNamed("tuesday"), &store_, {});
  }

  testing::TempDir dir_;
  MapStore store_;
};

TEST_F(MisplacedPart, IsRefusedHoweverFarItStandsFromTheRest) {
  EXPECT_GT(IngestWithPartMoved(16, Eigen::Vector3d::Zero()).comparison.num_localized, 10);
  for (const int first_image_idx : {8, 10}) {
    for (const Eigen::Vector3d& shift_in_enu :
         {Eigen::Vector3d(0, 12, 0), Eigen::Vector3d(-30, 0, 0), Eigen::Vector3d(200, 200, 0)}) {
      EXPECT_THAT([&] { IngestWithPartMoved(first_image_idx, shift_in_enu); },
                  ThrowsMessage<SessionRefused>(HasSubstr("contradicts the map: the map")))
          << "images from " << first_image_idx << ", moved by " << shift_in_enu.transpose();
    }
  }
}

TEST_F(MisplacedPart, ASessionFarFromAllTilesIsFoundByWhatItShows) {
  const testing::StreetWorld tuesday(OnTuesday());
  Sim3d ecef_from_world = tuesday.EcefFromWorld();
  ecef_from_world.translation +=
      EcefFromEnu(tuesday.options().origin).rotation * Eigen::Vector3d(0.0, 700.0, 0.0);
  EXPECT_THAT(
      [&] {
        IngestSession(tuesday.Reconstruct(), ecef_from_world, SessionNamed("far"), &store_, {});
      },
      ThrowsMessage<SessionRefused>(::testing::ContainsRegex("sees [0-9]+ of its photos 700\\.")));
}

TEST_F(MisplacedPart, AnotherStreetBeyondTheMapIsTaken) {
  testing::StreetWorldOptions beyond = OnTuesday();
  beyond.seed = 9;
  const testing::StreetWorld street(beyond);
  Sim3d ecef_from_world = street.EcefFromWorld();
  ecef_from_world.translation +=
      EcefFromEnu(beyond.origin).rotation * Eigen::Vector3d(0.0, 700.0, 0.0);
  const IngestReport report =
      IngestSession(street.Reconstruct(), ecef_from_world, SessionNamed("beyond"), &store_, {});
  EXPECT_EQ(report.comparison.num_expected, 0);
  EXPECT_EQ(report.comparison.num_sought, 6);
  EXPECT_EQ(report.comparison.num_found, 0);
  EXPECT_NEAR(report.comparison.nearest_tile_m.value(), 600.0, 100.0);
  // Its earlier self does not count as the map.
  ecef_from_world.translation += Eigen::Vector3d(0.5, 0.0, 0.0);
  const IngestReport again =
      IngestSession(street.Reconstruct(), ecef_from_world, SessionNamed("beyond"), &store_, {});
  EXPECT_GT(again.comparison.nearest_tile_m.value(), 500.0);
}

// The last frames of the session stand on the other side of the road, or in the next one.
TEST(MisplacedPartOfADrive, OfKittiIsRefused) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  testing::KittiThirds drive;
  for (const Eigen::Vector3d& shift_in_enu :
       {Eigen::Vector3d(0.0, 9.5, 0.0), Eigen::Vector3d(0.0, 60.0, 0.0)}) {
    for (const int first_image_idx : {8, 12}) {
      const Reconstruction session =
          WithPartMoved(drive.Third(1), first_image_idx,
                        InWorld(drive.ecef_from_world(), drive.place(), shift_in_enu));
      EXPECT_THAT(
          [&] {
            IngestSession(session, drive.ecef_from_world(), SessionNamed("wrong"), drive.store(),
                          {});
          },
          ThrowsMessage<SessionRefused>(HasSubstr("agree on another motion")))
          << "images from " << first_image_idx << ", moved by " << shift_in_enu.transpose();
    }
  }
}

}  // namespace
}  // namespace cairn
