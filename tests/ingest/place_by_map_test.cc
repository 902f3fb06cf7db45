// Photos without a scale stand where a map recognizes them.
#include "ingest/place/place_by_map.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "ingest/ingest_session.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

testing::StreetWorldOptions SmallStreet(uint64_t view_seed, uint64_t seed = 1) {
  testing::StreetWorldOptions options;
  options.length_m = 60.0;
  options.num_landmarks = 1500;
  options.view_seed = view_seed;
  options.seed = seed;
  return options;
}

class PlaceByMapTest : public ::testing::Test {
 protected:
  PlaceByMapTest() : map_(MapStore::Create(dir_.File("map.gpkg"))) {
    const testing::StreetWorld monday(SmallStreet(2));
    IngestSession(monday.Reconstruct(), monday.EcefFromWorld(), testing::SessionNamed("monday"),
                  &map_, {});
  }

  // The first photos of a walk, turned upside down and three times as large, and where each stands.
  void Take(const testing::StreetWorld& walk, int num_photos) {
    const Reconstruction all = walk.Reconstruct();
    std::vector<int> images;
    for (int i = 0; i < num_photos; ++i) {
      images.push_back(i);
    }
    photos_ = SelectImages(all, images);
    positions_.clear();
    centers_in_ecef_.clear();
    const Sim3d turned_from_world = {
        3.0, Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Eigen::Vector3d(1, 2, 0.5).normalized())),
        Eigen::Vector3d(7, -4, 2)};
    for (ReconImage& image : photos_.images) {
      centers_in_ecef_.push_back(walk.EcefFromWorld() * image.cam_from_world.Inverse().translation);
      positions_.push_back(GeodeticFromEcef(centers_in_ecef_.back() + Eigen::Vector3d(9, -7, 5)));
      image.cam_from_world = CamFromTarget(image.cam_from_world, turned_from_world);
    }
  }

  PlacementByMap Place(int num_threads = 1) const {
    const MapSnapshot snapshot = map_.Snapshot();
    return PlaceByMap(photos_, positions_, KnownTiles(snapshot), num_threads);
  }

  double WorstErrorM(const Sim3d& ecef_from_world) const {
    double worst_m = 0.0;
    for (size_t i = 0; i < photos_.images.size(); ++i) {
      const Eigen::Vector3d found =
          ecef_from_world * photos_.images[i].cam_from_world.Inverse().translation;
      worst_m = std::max(worst_m, (found - centers_in_ecef_[i]).norm());
    }
    return worst_m;
  }

  testing::TempDir dir_;
  MapStore map_;
  Reconstruction photos_;
  std::vector<std::optional<Geodetic>> positions_;
  std::vector<Eigen::Vector3d> centers_in_ecef_;
};

TEST_F(PlaceByMapTest, FindsPlaceTiltAndScale) {
  Take(testing::StreetWorld(SmallStreet(77)), 5);
  const PlacementByMap placed = Place();
  ASSERT_TRUE(placed.ecef_from_world);
  EXPECT_EQ(placed.num_asked, 5);
  EXPECT_GE(placed.num_agreeing, 3);
  EXPECT_LT(WorstErrorM(*placed.ecef_from_world), 0.15);
  EXPECT_EQ(Place(2).ecef_from_world->translation, placed.ecef_from_world->translation);
}

TEST_F(PlaceByMapTest, IgnoresPhotosThatTheModelHasInAWrongPlace) {
  Take(testing::StreetWorld(SmallStreet(77)), 8);
  for (const int wrong : {1, 4, 6}) {
    photos_.images[wrong].cam_from_world.translation += Eigen::Vector3d(20.0, 0.0, 9.0 * wrong);
  }
  const PlacementByMap placed = Place();
  ASSERT_TRUE(placed.ecef_from_world);
  EXPECT_LE(placed.num_agreeing, 5);
  for (const int right : {0, 2, 3, 5, 7}) {
    const Eigen::Vector3d found =
        *placed.ecef_from_world * photos_.images[right].cam_from_world.Inverse().translation;
    EXPECT_LT((found - centers_in_ecef_[right]).norm(), 0.2);
  }
}

TEST_F(PlaceByMapTest, PlacesNothingOfAnotherStreet) {
  Take(testing::StreetWorld(SmallStreet(77, /*seed=*/99)), 6);
  const PlacementByMap placed = Place();
  EXPECT_EQ(placed.num_asked, 6);
  EXPECT_FALSE(placed.ecef_from_world);
}

TEST_F(PlaceByMapTest, AsksNoPhotoWithoutAPosition) {
  Take(testing::StreetWorld(SmallStreet(77)), 5);
  positions_.assign(5, std::nullopt);
  const PlacementByMap placed = Place();
  EXPECT_EQ(placed.num_asked, 0);
  EXPECT_FALSE(placed.ecef_from_world);
}

TEST_F(PlaceByMapTest, AsksAnEmptyMapNothing) {
  Take(testing::StreetWorld(SmallStreet(77)), 5);
  const MapStore empty = MapStore::Create(dir_.File("empty.gpkg"));
  const MapSnapshot snapshot = empty.Snapshot();
  EXPECT_EQ(PlaceByMap(photos_, positions_, KnownTiles(snapshot), 1).num_asked, 0);
}

}  // namespace
}  // namespace cairn
