// A session that drifts by decimeters is bent to fit the map, and so finds the landmarks that it
// shares with the map.
#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"
#include "ingest/ingest_session.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

testing::StreetWorldOptions LongStreet(uint64_t view_seed) {
  testing::StreetWorldOptions options;
  options.length_m = 150.0;
  options.num_landmarks = 2500;
  options.view_seed = view_seed;
  return options;
}

// 0.3 m to the side and up over 100 m of the street.
Eigen::Vector3d DriftAt(double along_m) {
  const double phase = 2.0 * kPi * along_m / 100.0;
  return 0.3 * Eigen::Vector3d(0.0, std::sin(phase), 0.5 * std::cos(phase));
}

// Cameras drift with their places, landmarks with the cameras that see them.
Reconstruction Drifted(Reconstruction session, const testing::StreetWorld& street) {
  const Sim3d& world_from_enu = street.options().world_from_enu;
  const Sim3d enu_from_world = world_from_enu.Inverse();
  const auto in_world = [&](const Eigen::Vector3d& shift_in_enu) -> Eigen::Vector3d {
    return world_from_enu.scale * (world_from_enu.rotation * shift_in_enu);
  };
  std::vector<Eigen::Vector3d> shifts_in_world;
  for (ReconImage& image : session.images) {
    Rigid3d world_from_cam = image.cam_from_world.Inverse();
    shifts_in_world.push_back(in_world(DriftAt((enu_from_world * world_from_cam.translation).x())));
    world_from_cam.translation += shifts_in_world.back();
    image.cam_from_world = world_from_cam.Inverse();
  }
  for (ReconLandmark& landmark : session.landmarks) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ReconObservation& seen : landmark.observations) {
      sum += shifts_in_world[static_cast<size_t>(seen.image_idx)];
    }
    landmark.x_in_world += sum / static_cast<double>(landmark.observations.size());
  }
  return session;
}

// The report of the second session of the street, as it is or with the drift.
IngestReport IngestTwice(bool drifts) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("map.gpkg"));
  const testing::StreetWorld monday(LongStreet(2)), tuesday(LongStreet(77));
  IngestSession(monday.Reconstruct(), monday.EcefFromWorld(), testing::SessionNamed("monday"),
                &store, {});
  const Reconstruction session = tuesday.Reconstruct();
  return IngestSession(drifts ? Drifted(session, tuesday) : session, tuesday.EcefFromWorld(),
                       testing::SessionNamed("tuesday"), &store, {});
}

TEST(DriftingSession, FindsTheLandmarksThatItWouldFindWithoutDrift) {
  const IngestReport straight = IngestTwice(false);
  const IngestReport bent = IngestTwice(true);
  EXPECT_TRUE(straight.comparison.bending.is_none());
  EXPECT_GT(bent.comparison.largest_bend_m, 0.2);
  EXPECT_LT(bent.comparison.fit.median_residual_m, 0.05);
  ASSERT_GT(straight.changes.num_merged, 1000);
  EXPECT_GE(bent.changes.num_merged, 0.97 * static_cast<double>(straight.changes.num_merged));
}

}  // namespace
}  // namespace cairn
