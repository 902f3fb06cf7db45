#include "lab/city/simulated_mapping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/error.h"
#include "core/statistics.h"
#include "lab/city/city_region.h"

namespace cairn {
namespace {

class MappedCity {
 public:
  explicit MappedCity(CityCharacter character,
                      const SimulatedMappingOptions& options = QuickMapping())
      : city_(Options(character)), model_({}), mapping_(city_, model_, options) {}

  static SimulatedMappingOptions QuickMapping() {
    SimulatedMappingOptions options;
    options.num_passes = 2;
    options.detector.max_keypoints = 250;
    options.min_observations = 3;
    return options;
  }
  static CityOptions Options(CityCharacter character) {
    CityOptions options = CityPreset(character);
    options.area_km2 = 0.01;
    options.min_landmark_size_m = 0.05;
    return options;
  }

  const City& city() const { return city_; }
  const SimulatedMapping& mapping() const { return mapping_; }
  MappedChunk Center(int num_threads = 2) const {
    return mapping_.MapTile(mapping_.Tiles().front(), num_threads);
  }
  // By id, at the time of the pass.
  std::unordered_map<uint64_t, Eigen::Vector3d> Truth(int pass) const {
    std::unordered_map<uint64_t, Eigen::Vector3d> truth;
    const CityRegion region(city_, BoxAroundPoint(Eigen::Vector2d::Zero(), 250.0),
                            mapping_.options().TimeYears(pass));
    for (const RegionSurface& surface : region.surfaces()) {
      for (const CityLandmark& landmark : surface.landmarks) {
        truth[landmark.id] = landmark.x_in_site;
      }
    }
    return truth;
  }

 private:
  City city_;
  DescriptorModel model_;
  SimulatedMapping mapping_;
};

void ExpectEqual(const MappedChunk& a, const MappedChunk& b) {
  ASSERT_EQ(a.reconstruction.images.size(), b.reconstruction.images.size());
  EXPECT_EQ(a.city_landmarks, b.city_landmarks);
  for (size_t i = 0; i < a.reconstruction.images.size(); ++i) {
    const ReconImage &x = a.reconstruction.images[i], &y = b.reconstruction.images[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.features.descriptors.Unpacked(), y.features.descriptors.Unpacked());
    EXPECT_EQ(x.cam_from_world.translation, y.cam_from_world.translation);
  }
  for (size_t i = 0; i < a.reconstruction.landmarks.size(); ++i) {
    EXPECT_EQ(a.reconstruction.landmarks[i].x_in_world, b.reconstruction.landmarks[i].x_in_world);
  }
}

TEST(SimulatedMapping, MakesAValidReconstructionOfOneTile) {
  const MappedCity mapped(CityCharacter::kOldTown);
  const MappedChunk chunk = mapped.Center();
  chunk.reconstruction.Validate();
  EXPECT_GT(chunk.num_keyframes, 20);
  EXPECT_EQ(chunk.reconstruction.images.size(), 4u * static_cast<size_t>(chunk.num_keyframes));
  EXPECT_GT(chunk.reconstruction.landmarks.size(), 600u);
  std::set<std::string> names;
  for (size_t i = 0; i < chunk.reconstruction.images.size(); ++i) {
    names.insert(chunk.reconstruction.images[i].name);
    const Geodetic at = GeodeticFromEcef(mapped.city().ecef_from_site() *
                                         chunk.cam_from_site[i].Inverse().translation);
    EXPECT_EQ(TileId::Containing(at), chunk.tile_id);
  }
  EXPECT_EQ(names.size(), chunk.reconstruction.images.size());
  for (const ReconLandmark& landmark : chunk.reconstruction.landmarks) {
    EXPECT_GE(landmark.observations.size(), 3u);
  }
}

TEST(SimulatedMapping, IsTheSameInAnyOrderAndOnAnyNumberOfThreads) {
  const MappedCity mapped(CityCharacter::kSuburb), again(CityCharacter::kSuburb);
  const std::vector<TileId> tiles = mapped.mapping().Tiles();
  ASSERT_GE(tiles.size(), 2u);
  const MappedChunk first = mapped.mapping().MapTile(tiles[0], 1);
  mapped.mapping().MapTile(tiles[1], 2);
  again.mapping().MapTile(tiles[1], 1);
  ExpectEqual(first, again.mapping().MapTile(tiles[0], 3));
}

TEST(SimulatedMapping, TilesOfASquareAcrossAZoneBorderBelongToBothZones) {
  const MappedCity mapped(CityCharacter::kSuburb);
  std::set<int> zones;
  size_t num_keyframes = 0;
  for (const TileId tile_id : mapped.mapping().Tiles()) {
    const MappedChunk chunk = mapped.mapping().MapTile(tile_id, 2);
    num_keyframes += static_cast<size_t>(chunk.num_keyframes);
    if (chunk.num_keyframes > 0) {
      zones.insert(tile_id.zone());
    }
  }
  EXPECT_EQ(zones, (std::set<int>{32, 33}));
  // No keyframe is lost or doubled between tiles.
  size_t num_in_square = 0;
  for (int pass = 0; pass < mapped.mapping().options().num_passes; ++pass) {
    num_in_square +=
        mapped.mapping().KeyframesIn(BoxAroundPoint(Eigen::Vector2d::Zero(), 60.0), pass).size();
  }
  EXPECT_EQ(num_keyframes, num_in_square);
}

TEST(SimulatedMapping, WithoutNoiseLandmarksAreWhereTheyAre) {
  SimulatedMappingOptions options = MappedCity::QuickMapping();
  options.noise = {.camera_position_m = 0.0,
                   .camera_rotation_rad = 0.0,
                   .pass_drift_m = 0.0,
                   .deformation_m = 0.0,
                   .wrong_observation_share = 0.0,
                   .gps_m = 0.0};
  options.detector.position_noise = 0.0;
  const MappedCity mapped(CityCharacter::kOldTown, options);
  const MappedChunk chunk = mapped.Center();
  const auto first = mapped.Truth(0), second = mapped.Truth(1);
  for (size_t i = 0; i < chunk.city_landmarks.size(); ++i) {
    const uint64_t id = chunk.city_landmarks[i];
    const Eigen::Vector3d& x_in_site = first.contains(id) ? first.at(id) : second.at(id);
    EXPECT_LT((chunk.reconstruction.landmarks[i].x_in_world - x_in_site).norm(), 5e-3);
  }
  for (size_t i = 0; i < chunk.cam_from_site.size(); ++i) {
    const Rigid3d& estimated = chunk.reconstruction.images[i].cam_from_world;
    EXPECT_LT((estimated.translation - chunk.cam_from_site[i].translation).norm(), 1e-9);
  }
}

TEST(SimulatedMapping, ErrorsAreAsLargeAsAskedFor) {
  SimulatedMappingOptions options = MappedCity::QuickMapping();
  options.noise.camera_position_m = 0.1;
  options.noise.pass_drift_m = 0.0;
  options.noise.deformation_m = 0.0;
  options.noise.gps_m = 4.0;
  const MappedCity mapped(CityCharacter::kOldTown, options);
  const MappedChunk chunk = mapped.Center();
  double sum_sq = 0.0, sum_sq_gps = 0.0;
  const size_t count = chunk.cam_from_site.size();
  for (size_t i = 0; i < count; i += 4) {
    const Eigen::Vector3d truth = chunk.cam_from_site[i].Inverse().translation;
    const ReconImage& image = chunk.reconstruction.images[i];
    sum_sq += (image.cam_from_world.Inverse().translation - truth).squaredNorm();
    sum_sq_gps +=
        (EcefFromGeodetic(*image.gps) - mapped.city().ecef_from_site() * truth).squaredNorm();
  }
  const double num_values = 3.0 * static_cast<double>(count) / 4.0;
  EXPECT_NEAR(std::sqrt(sum_sq / num_values), 0.1, 0.015);
  EXPECT_NEAR(std::sqrt(sum_sq_gps / num_values), 4.0, 0.6);
}

TEST(SimulatedMapping, DeformationMovesCamerasAndLandmarksTogether) {
  SimulatedMappingOptions options = MappedCity::QuickMapping();
  options.noise = {.camera_position_m = 0.0,
                   .camera_rotation_rad = 0.0,
                   .pass_drift_m = 0.0,
                   .deformation_m = 1.0,
                   .wrong_observation_share = 0.0};
  options.detector.position_noise = 0.0;
  const MappedCity mapped(CityCharacter::kOldTown, options);
  const MappedChunk chunk = mapped.Center();
  const auto truth = mapped.Truth(0);
  std::vector<double> errors_m, differences_m;
  for (size_t i = 0; i < chunk.city_landmarks.size(); ++i) {
    const auto found = truth.find(chunk.city_landmarks[i]);
    if (found == truth.end()) {
      continue;
    }
    const ReconLandmark& landmark = chunk.reconstruction.landmarks[i];
    const auto image_idx = static_cast<size_t>(landmark.observations[0].image_idx);
    const Eigen::Vector3d shift =
        chunk.reconstruction.images[image_idx].cam_from_world.Inverse().translation -
        chunk.cam_from_site[image_idx].Inverse().translation;
    const Eigen::Vector3d error = landmark.x_in_world - found->second;
    errors_m.push_back(error.norm());
    differences_m.push_back((error - shift).norm());
  }
  ASSERT_GT(errors_m.size(), 500u);
  EXPECT_GT(Median(errors_m), 0.2);
  EXPECT_LT(Median(differences_m), 0.2 * Median(errors_m));
}

TEST(SimulatedMapping, KeypointsAreNoisyAsAskedFor) {
  SimulatedMappingOptions options = MappedCity::QuickMapping();
  options.noise.wrong_observation_share = 0.0;
  options.detector.position_noise = 1.0;
  options.detector.max_scale_px = 2.0;  // Small keypoints: half a pixel an axis.
  const MappedCity mapped(CityCharacter::kOldTown, options);
  const MappedChunk chunk = mapped.Center();
  const auto truth = mapped.Truth(0);
  double sum_sq = 0.0;
  int count = 0;
  for (size_t i = 0; i < chunk.city_landmarks.size(); ++i) {
    const auto found = truth.find(chunk.city_landmarks[i]);
    if (found == truth.end()) {
      continue;
    }
    for (const ReconObservation& observation : chunk.reconstruction.landmarks[i].observations) {
      const auto image_idx = static_cast<size_t>(observation.image_idx);
      const Keypoint& keypoint =
          chunk.reconstruction.images[image_idx]
              .features.keypoints[static_cast<size_t>(observation.keypoint_idx)];
      const auto pixel =
          chunk.reconstruction.cameras[0].Project(chunk.cam_from_site[image_idx] * found->second);
      ASSERT_TRUE(pixel);
      sum_sq += (*pixel - Eigen::Vector2d(keypoint.x_px, keypoint.y_px)).squaredNorm();
      ++count;
    }
  }
  ASSERT_GT(count, 1000);
  EXPECT_NEAR(std::sqrt(0.5 * sum_sq / count), 0.5, 0.03);
}

TEST(SimulatedMapping, ClutterIsAsMuchAsAskedForAndInNoTrack) {
  SimulatedMappingOptions options = MappedCity::QuickMapping();
  const MappedCity plain(CityCharacter::kOldTown, options);
  options.clutter_ratio = 1.5;
  const MappedCity cluttered(CityCharacter::kOldTown, options);
  const MappedChunk without = plain.Center(), with = cluttered.Center();
  ASSERT_EQ(without.reconstruction.images.size(), with.reconstruction.images.size());
  for (size_t i = 0; i < with.reconstruction.images.size(); ++i) {
    const int num_seen = without.reconstruction.images[i].features.size();
    EXPECT_EQ(with.reconstruction.images[i].features.size(),
              num_seen + static_cast<int>(std::lround(1.5 * num_seen)));
  }
  EXPECT_EQ(without.city_landmarks, with.city_landmarks);
}

TEST(SimulatedMapping, OneThingBecomesSeveralLandmarksWhereMatchingFails) {
  SimulatedMappingOptions options = MappedCity::QuickMapping();
  options.track_view_rad = 7.0;
  options.track_octaves = 20.0;
  options.pass_join_share = 1.0;
  const auto per_thing = [](const MappedChunk& chunk) {
    const std::unordered_set<uint64_t> things(chunk.city_landmarks.begin(),
                                              chunk.city_landmarks.end());
    return static_cast<double>(chunk.city_landmarks.size()) / static_cast<double>(things.size());
  };
  EXPECT_LT(per_thing(MappedCity(CityCharacter::kOldTown, options).Center()), 1.3);
  options.pass_join_share = 0.0;
  options.track_view_rad = 0.5;
  options.keyframe_spacing_m = 1.0;
  EXPECT_GT(per_thing(MappedCity(CityCharacter::kOldTown, options).Center()), 1.5);
}

TEST(SimulatedMapping, TheMapForgetsWhatEachPassAloneSaw) {
  SimulatedMappingOptions options = MappedCity::QuickMapping();
  options.years = 10.0;
  const MappedCity mapped(CityCharacter::kGrid, options);
  const MappedChunk chunk = mapped.Center();
  const auto before = mapped.Truth(0), after = mapped.Truth(1);
  int num_only_before = 0, num_only_after = 0, num_both = 0;
  for (const uint64_t id : chunk.city_landmarks) {
    num_only_before += before.contains(id) && !after.contains(id);
    num_only_after += !before.contains(id) && after.contains(id);
    num_both += before.contains(id) && after.contains(id);
  }
  EXPECT_EQ(num_only_before + num_only_after + num_both,
            static_cast<int>(chunk.city_landmarks.size()));
  EXPECT_GT(num_only_before, 50);
  EXPECT_GT(num_only_after, 50);
  EXPECT_GT(num_both, 50);
}

TEST(SimulatedMapping, TheEstimateOfObservationsIsAnUpperBoundOfTheRightOrder) {
  const MappedCity mapped(CityCharacter::kGrid);
  double num_observations = 0.0;
  for (const TileId tile_id : mapped.mapping().Tiles()) {
    for (const ReconLandmark& landmark :
         mapped.mapping().MapTile(tile_id, 2).reconstruction.landmarks) {
      num_observations += static_cast<double>(landmark.observations.size());
    }
  }
  EXPECT_LT(num_observations, mapped.mapping().ExpectedObservations());
  EXPECT_GT(num_observations, 0.01 * mapped.mapping().ExpectedObservations());
}

}  // namespace
}  // namespace cairn
