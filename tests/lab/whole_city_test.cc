#include "lab/city/whole_city.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/error.h"
#include "ingest/colmap/colmap_reader.h"
#include "ingest/colmap/write_colmap.h"
#include "lab/city/city_world.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

constexpr double kPlentyBytes = 4e9;

class QuickCity : public ::testing::Test {
 protected:
  QuickCity()
      : options_(CityWorldPreset(CityCharacter::kOldTown, CityWorldSize::kQuick)),
        city_(options_.city),
        model_(options_.descriptors),
        mapping_(city_, model_, options_.mapping) {}

  CityWorldOptions options_;
  City city_;
  DescriptorModel model_;
  SimulatedMapping mapping_;
};

TEST_F(QuickCity, TheWholeIsItsTilesOneAfterTheOther) {
  const Reconstruction whole = MapWholeCity(mapping_, 2, kPlentyBytes, {});
  whole.Validate();
  size_t num_images = 0, num_landmarks = 0;
  for (const TileId tile_id : mapping_.Tiles()) {
    const MappedChunk chunk = mapping_.MapTile(tile_id, 2);
    num_images += chunk.reconstruction.images.size();
    num_landmarks += chunk.reconstruction.landmarks.size();
  }
  EXPECT_EQ(whole.images.size(), num_images);
  EXPECT_EQ(whole.landmarks.size(), num_landmarks);
}

TEST_F(QuickCity, ColmapsReaderReadsItBack) {
  const Reconstruction whole = MapWholeCity(mapping_, 2, kPlentyBytes, {});
  const testing::TempDir dir;
  WriteColmapModel(whole, dir.path().string(), ColmapModelFormat::kBinary);
  WriteColmapDatabase(whole, dir.File("database.db"), {});
  const Reconstruction read = ReadColmap({dir.path().string(), dir.File("database.db"), {}});
  ASSERT_EQ(read.images.size(), whole.images.size());
  ASSERT_EQ(read.landmarks.size(), whole.landmarks.size());
  EXPECT_EQ(read.landmarks[5].x_in_world, whole.landmarks[5].x_in_world);
  const ReconImage& image = read.images[3];  // The reader sorts by name.
  const auto same = std::ranges::find(whole.images, image.name, &ReconImage::name);
  ASSERT_NE(same, whole.images.end());
  ASSERT_TRUE(image.gps);
  EXPECT_NEAR(image.gps->lat_deg(), same->gps->lat_deg(), 1e-9);
  const FeatureSet a = image.features.Unpacked(), b = same->features.Unpacked();
  ASSERT_EQ(a.size(), b.size());
  for (int i = 0; i < a.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    EXPECT_EQ(a.keypoints[k].x_px, b.keypoints[k].x_px);
    EXPECT_NEAR(a.keypoints[k].scale_px, b.keypoints[k].scale_px, 1e-4);
    // Bytes of the root, as COLMAP has it.
    const auto root = [](const auto& row) {
      return Eigen::VectorXf((row / row.template lpNorm<1>()).cwiseSqrt().transpose());
    };
    EXPECT_LT((root(a.descriptors.row(i)) - root(b.descriptors.row(i))).norm(), 0.03);
  }
}

TEST_F(QuickCity, TooMuchForTheMemoryIsRefusedWithTheLargestArea) {
  EXPECT_THAT(
      [&] { MapWholeCity(mapping_, 2, 1e6, {}); },
      ::testing::ThrowsMessage<Error>(::testing::HasSubstr("city.area_km2 = 0.01 needs up to")));
}

}  // namespace
}  // namespace cairn
