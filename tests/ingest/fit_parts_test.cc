// Parts of a session, each placed by its own positions, are moved to where the map sees them.
#include "ingest/fit_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "ingest/ingest_session.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

testing::StreetWorldOptions Street(uint64_t view_seed, uint64_t seed = 1) {
  testing::StreetWorldOptions options;
  options.length_m = 120.0;
  options.num_landmarks = 2000;
  options.view_seed = view_seed;
  options.seed = seed;
  return options;
}

// The photos between two places along the street, as if they knew of no others.
Reconstruction Stretch(const testing::StreetWorld& street, double from_m, double to_m) {
  const Reconstruction all = street.Reconstruct();
  const Sim3d enu_from_world = street.options().world_from_enu.Inverse();
  std::vector<int> images;
  for (size_t i = 0; i < all.images.size(); ++i) {
    const double along_m =
        (enu_from_world * all.images[i].cam_from_world.Inverse().translation).x();
    if (from_m <= along_m && along_m < to_m) {
      images.push_back(static_cast<int>(i));
    }
  }
  Reconstruction stretch = SelectImages(all, images);
  std::erase_if(stretch.landmarks,
                [](const ReconLandmark& landmark) { return landmark.observations.size() < 2; });
  return stretch;
}

// The reconstruction after an error of its positions.
Reconstruction Misplaced(Reconstruction part, const Sim3d& wrong_from_world) {
  for (ReconImage& image : part.images) {
    image.cam_from_world = CamFromTarget(image.cam_from_world, wrong_from_world);
  }
  for (ReconLandmark& landmark : part.landmarks) {
    landmark.x_in_world = wrong_from_world * landmark.x_in_world;
  }
  return part;
}

Reconstruction Joined(Reconstruction a, const Reconstruction& b) {
  const auto num_images = static_cast<int>(a.images.size());
  a.images.insert(a.images.end(), b.images.begin(), b.images.end());
  for (ReconLandmark landmark : b.landmarks) {
    for (ReconObservation& seen : landmark.observations) {
      seen.image_idx += num_images;
    }
    a.landmarks.push_back(std::move(landmark));
  }
  return a;
}

class FitPartsTest : public ::testing::Test {
 protected:
  FitPartsTest() : map_(MapStore::Create(dir_.File("map.gpkg"))) {
    const testing::StreetWorld monday(Street(2));
    IngestSession(monday.Reconstruct(), monday.EcefFromWorld(), testing::SessionNamed("monday"),
                  &map_, {});
  }

  // In the world of the street, about its origin: meters and a turn about the vertical.
  Sim3d Error(const Eigen::Vector3d& shift_in_enu, double yaw_rad) const {
    const Sim3d& world_from_enu = tuesday_.options().world_from_enu;
    const Sim3d wrong_from_enu = {
        1.0, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())),
        shift_in_enu};
    return world_from_enu * wrong_from_enu * world_from_enu.Inverse();
  }

  // Joins the parts and fits them.
  std::map<int, SessionPart> Fit(const Reconstruction& a, const Reconstruction& b,
                                 const Sim3d& ecef_from_world,
                                 const std::set<int>& placed_by_map = {}) {
    std::vector<int> part_of_image(a.images.size(), 0);
    part_of_image.resize(a.images.size() + b.images.size(), 1);
    session_ = Joined(a, b);
    IngestOptions options = testing::SessionNamed("tuesday");
    options.agreement.position_accuracy_m = 4.5;
    return FitParts(map_.Snapshot(), part_of_image, placed_by_map, ecef_from_world, options,
                    &session_);
  }

  // The largest distance of a camera from its place in the street, meters.
  double WorstErrorM() const {
    const Reconstruction truth = tuesday_.Reconstruct();
    double worst = 0.0;
    for (const ReconImage& image : session_.images) {
      for (const ReconImage& other : truth.images) {
        if (other.name == image.name) {
          const Eigen::Vector3d error = image.cam_from_world.Inverse().translation -
                                        other.cam_from_world.Inverse().translation;
          worst = std::max(worst, tuesday_.EcefFromWorld().scale * error.norm());
        }
      }
    }
    return worst;
  }

  testing::TempDir dir_;
  MapStore map_;
  const testing::StreetWorld tuesday_ = testing::StreetWorld(Street(77));
  Reconstruction session_;
};

TEST_F(FitPartsTest, MovesEachPartByItself) {
  const Reconstruction a = Misplaced(Stretch(tuesday_, 0, 50), Error({2.0, 1.0, 0.5}, 0.02));
  const Reconstruction b = Misplaced(Stretch(tuesday_, 70, 120), Error({-1.5, -2.0, 0.0}, -0.01));
  const auto parts = Fit(a, b, tuesday_.EcefFromWorld());
  EXPECT_EQ(session_.images.size(), a.images.size() + b.images.size());
  EXPECT_GT(parts.at(0).moved_m, 1.0);
  EXPECT_GT(parts.at(1).moved_m, 1.0);
  EXPECT_LT(WorstErrorM(), 0.1);
}

TEST_F(FitPartsTest, LeavesOutAPartThatTheMapDoesNotAnchor) {
  const testing::StreetWorld elsewhere(Street(77, /*seed=*/99));
  const Reconstruction a = Misplaced(Stretch(tuesday_, 0, 50), Error({2.0, 1.0, 0.5}, 0.02));
  const auto parts = Fit(a, Stretch(elsewhere, 70, 120), tuesday_.EcefFromWorld());
  EXPECT_EQ(session_.images.size(), a.images.size());
  EXPECT_EQ(parts.at(0).problem, "");
  EXPECT_THAT(parts.at(1).problem, HasSubstr("a part of "));
  EXPECT_LT(WorstErrorM(), 0.1);
}

TEST_F(FitPartsTest, LeavesOutAPartWithoutAGoodLandmark) {
  const Reconstruction a = Misplaced(Stretch(tuesday_, 0, 50), Error({2.0, 1.0, 0.5}, 0.02));
  Reconstruction b = Stretch(tuesday_, 70, 120);
  b.landmarks.clear();
  const auto parts = Fit(a, b, tuesday_.EcefFromWorld());
  EXPECT_EQ(session_.images.size(), a.images.size());
  EXPECT_NE(parts.at(1).problem, "");
}

TEST_F(FitPartsTest, LeavesTheLargestPartToTheIngestIfTheMapAnchorsNone) {
  const testing::StreetWorld elsewhere(Street(77, /*seed=*/99));
  const Reconstruction a = Stretch(elsewhere, 0, 30);
  const Reconstruction b = Stretch(elsewhere, 50, 120);
  const auto parts = Fit(a, b, tuesday_.EcefFromWorld());
  EXPECT_NE(parts.at(0).problem, "");
  EXPECT_EQ(parts.at(1).problem, "");
  EXPECT_EQ(session_.images.size(), b.images.size());
}

TEST_F(FitPartsTest, LeavesOutALargerPartThatOnlyTheMapPlacedIfItAnchorsNone) {
  const testing::StreetWorld elsewhere(Street(77, /*seed=*/99));
  const Reconstruction a = Stretch(elsewhere, 0, 30);
  const auto parts = Fit(a, Stretch(elsewhere, 50, 120), tuesday_.EcefFromWorld(), {1});
  EXPECT_EQ(parts.at(0).problem, "");
  EXPECT_NE(parts.at(1).problem, "");
  EXPECT_EQ(session_.images.size(), a.images.size());
}

TEST_F(FitPartsTest, KeepsAWalkOverNewGroundAndNotTheFewPhotosThatOnlyTheMapPlaced) {
  const testing::StreetWorld elsewhere(Street(77, /*seed=*/99));
  const Reconstruction walk = Stretch(elsewhere, 0, 70);
  const Reconstruction corner = Stretch(tuesday_, 90, 120);
  ASSERT_LT(corner.images.size(), walk.images.size());
  const auto parts = Fit(walk, corner, tuesday_.EcefFromWorld(), {1});
  EXPECT_EQ(session_.images.size(), walk.images.size());
  EXPECT_EQ(parts.at(0).problem, "");
  EXPECT_THAT(parts.at(1).problem, HasSubstr("the map sees it"));
}

TEST_F(FitPartsTest, KeepsWhatTheMapPlacedIfThatIsMostOfTheSession) {
  const testing::StreetWorld elsewhere(Street(77, /*seed=*/99));
  const Reconstruction walk = Stretch(tuesday_, 0, 70);
  const auto parts = Fit(walk, Stretch(elsewhere, 90, 120), tuesday_.EcefFromWorld(), {0});
  EXPECT_EQ(session_.images.size(), walk.images.size());
  EXPECT_EQ(parts.at(0).problem, "");
  EXPECT_NE(parts.at(1).problem, "");
}

TEST_F(FitPartsTest, KeepsAllPartsFarFromTheMap) {
  Sim3d far_away = tuesday_.EcefFromWorld();
  far_away.translation += 3000.0 * (far_away.rotation * Eigen::Vector3d::UnitX());
  const Reconstruction a = Stretch(tuesday_, 0, 50);
  const Reconstruction b = Stretch(tuesday_, 70, 120);
  Fit(a, b, far_away);
  EXPECT_EQ(session_.images.size(), a.images.size() + b.images.size());
  EXPECT_LT(WorstErrorM(), 1e-9);
}

}  // namespace
}  // namespace cairn
