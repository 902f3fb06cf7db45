#include "lab/descriptors/real_looks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/error.h"
#include "core/statistics.h"
#include "lab/descriptors/descriptor_statistics.h"

namespace cairn {
namespace {

StreetOptions SmallStreet() {
  StreetOptions street;
  street.length_m = 40.0;
  street.mapping_step_m = 4.0;
  street.num_queries = 2;
  street.image_width_px = 320;
  street.image_height_px = 240;
  street.focal_px = 210.0;
  return street;
}

// A picture of soft blobs.
GrayImage Blobs(int width_px, int height_px) {
  std::mt19937_64 rng(1);
  std::vector<float> light(static_cast<size_t>(width_px) * height_px, 128.0f);
  for (int blob = 0; blob < 500; ++blob) {
    const double x = rng() % width_px, y = rng() % height_px;
    const double radius = 2.0 + rng() % 6;
    const double height = rng() % 2 == 0 ? 60.0 : -60.0;
    for (int row = 0; row < height_px; ++row) {
      for (int column = 0; column < width_px; ++column) {
        const double sq = (std::pow(column - x, 2) + std::pow(row - y, 2)) / (radius * radius);
        light[static_cast<size_t>(row) * width_px + column] +=
            static_cast<float>(height * std::exp(-0.5 * sq));
      }
    }
  }
  GrayImage image{.width_px = width_px, .height_px = height_px, .pixels = {}};
  for (const float value : light) {
    image.pixels.push_back(static_cast<uint8_t>(std::clamp(value, 0.0f, 255.0f)));
  }
  return image;
}

GrayImage Crop(const GrayImage& image, int left, int top, int width_px, int height_px) {
  GrayImage crop{.width_px = width_px, .height_px = height_px, .pixels = {}};
  for (int row = 0; row < height_px; ++row) {
    const auto begin =
        image.pixels.begin() + static_cast<std::ptrdiff_t>(top + row) * image.width_px + left;
    crop.pixels.insert(crop.pixels.end(), begin, begin + width_px);
  }
  return crop;
}

TEST(LooksAtStreet, FindsLandmarksAgainAndLittleByChance) {
  const RealLooks looks = LooksAtStreet(SmallStreet());
  const std::vector<LookPair> pairs = PairsOf(looks.looks);
  ASSERT_GT(pairs.size(), 200u);
  EXPECT_LT(ValueAtShare(SqDistances(looks.root, pairs), 0.5), 0.3f * 0.3f);
  for (const RealLook& look : looks.looks) {
    EXPECT_LT(std::abs(look.azimuth_rad), 1.6f);
  }
  RealLooksOptions beside;
  beside.offset_px = {23.0, 11.0};
  EXPECT_LT(PairsOf(LooksAtStreet(SmallStreet(), beside).looks).size(), pairs.size() / 5);
}

TEST(LooksAtFacade, FindsAPictureInItsCrop) {
  const GrayImage picture = Blobs(320, 260);
  const RealLooks looks =
      LooksAtFacade({Crop(picture, 0, 0, 300, 240), Crop(picture, 17, 9, 300, 240)});
  const std::vector<LookPair> pairs = PairsOf(looks.looks);
  ASSERT_GT(pairs.size(), 50u);
  for (const LookPair& pair : pairs) {
    EXPECT_LT(pair.angle_rad, 0.1f);
    EXPECT_LT(pair.log2_scale, 0.02f);
    EXPECT_NE(looks.looks[pair.a].appearance_mode, looks.looks[pair.b].appearance_mode);
  }
  EXPECT_LT(ValueAtShare(SqDistances(looks.root, pairs), 0.5), 0.05f * 0.05f);
}

TEST(LooksAtFacade, DifferentPicturesHaveNothingInCommon) {
  const GrayImage blank{.width_px = 200, .height_px = 200, .pixels = std::vector<uint8_t>(40000)};
  EXPECT_EQ(LooksAtFacade({Blobs(200, 200), blank}).size(), 0);
}

TEST(RealLooksOptions, RefuseNonsense) {
  EXPECT_THROW(LooksAtReconstruction({}, {.max_distance_px = 0.0}), Error);
  EXPECT_THROW(LooksAtReconstruction({}, {.max_landmarks = 0}), Error);
}

}  // namespace
}  // namespace cairn
