#include "core/features/sift/sift_extractor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/error.h"

namespace cairn {
namespace {

struct Blob {
  double x_px, y_px, sigma_px;
};

// Gaussian blobs on gray; positions in our pixel convention.
GrayImage DrawBlobs(int width_px, int height_px, const std::vector<Blob>& blobs) {
  GrayImage image{width_px, height_px, std::vector<uint8_t>(width_px * height_px)};
  for (int row = 0; row < height_px; ++row) {
    for (int col = 0; col < width_px; ++col) {
      double value = 60.0;
      for (const Blob& blob : blobs) {
        const double dx = col + 0.5 - blob.x_px, dy = row + 0.5 - blob.y_px;
        value += 150.0 * std::exp(-0.5 * (dx * dx + dy * dy) / (blob.sigma_px * blob.sigma_px));
      }
      image.pixels[row * width_px + col] =
          static_cast<uint8_t>(std::lround(std::min(value, 255.0)));
    }
  }
  return image;
}

const Keypoint& Nearest(const FeatureSet& features, const Blob& blob) {
  return *std::min_element(features.keypoints.begin(), features.keypoints.end(),
                           [&](const Keypoint& a, const Keypoint& b) {
                             return std::hypot(a.x_px - blob.x_px, a.y_px - blob.y_px) <
                                    std::hypot(b.x_px - blob.x_px, b.y_px - blob.y_px);
                           });
}

GrayImage Noise(int width_px, int height_px) {
  std::vector<Blob> blobs;
  uint64_t state = 12345;
  const auto next = [&] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 33) / static_cast<double>(1u << 31);
  };
  for (int i = 0; i < 60; ++i) {
    blobs.push_back({next() * width_px, next() * height_px, 1.5 + 4.0 * next()});
  }
  return DrawBlobs(width_px, height_px, blobs);
}

TEST(ExtractSift, PutsKeypointsOnTheCentersOfBlobs) {
  const std::vector<Blob> blobs = {
      {40.5, 40.5, 3.0}, {90.1, 40.25, 4.0}, {40.8, 90.3, 3.5}, {95.3, 95.7, 5.0}};
  const FeatureSet features = ExtractSift(DrawBlobs(140, 140, blobs));
  ASSERT_GE(features.size(), 4);
  for (const Blob& blob : blobs) {
    const Keypoint& keypoint = Nearest(features, blob);
    EXPECT_NEAR(keypoint.x_px, blob.x_px, 0.06);
    EXPECT_NEAR(keypoint.y_px, blob.y_px, 0.06);
    // A difference of Gaussians 2^(1/3) apart responds most a little below the blob's own sigma.
    EXPECT_NEAR(keypoint.scale_px / blob.sigma_px, 0.95, 0.15);
  }
}

// (x, y) of a square image becomes (side - y, x): what pointed along x now points along y.
TEST(ExtractSift, OrientationTurnsWithTheImage) {
  constexpr int kSide = 128;
  const GrayImage image = Noise(kSide, kSide);
  GrayImage turned = image;
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col) {
      turned.pixels[col * kSide + (kSide - 1 - row)] = image.pixels[row * kSide + col];
    }
  }
  const FeatureSet features = ExtractSift(image);
  const FeatureSet turned_features = ExtractSift(turned);
  int num_found = 0;
  for (const Keypoint& a : features.keypoints) {
    num_found += std::any_of(
        turned_features.keypoints.begin(), turned_features.keypoints.end(), [&](const Keypoint& b) {
          return std::hypot(b.x_px - (kSide - a.y_px), b.y_px - a.x_px) < 0.3 &&
                 std::abs(WrapAngleRad(b.orientation_rad - a.orientation_rad - kPi / 2.0)) < 0.1;
        });
  }
  // Round blobs leave some orientations to chance.
  EXPECT_GT(num_found, features.size() / 2);
}

TEST(ExtractSift, ReducedImagesGiveKeypointsInTheOriginalsPixels) {
  const std::vector<Blob> blobs = {{101.0, 102.0, 8.0}, {60.0, 150.0, 10.0}};
  const GrayImage image = DrawBlobs(201, 205, blobs);
  for (const int max_pixels : {15'000, 41'000}) {
    const FeatureSet features = ExtractSift(image, {.max_pixels = max_pixels});
    for (const Blob& blob : blobs) {
      const Keypoint& keypoint = Nearest(features, blob);
      EXPECT_NEAR(keypoint.x_px, blob.x_px, 0.15);
      EXPECT_NEAR(keypoint.y_px, blob.y_px, 0.15);
      EXPECT_NEAR(keypoint.scale_px / blob.sigma_px, 0.95, 0.15);
    }
  }
}

TEST(ExtractSift, StopsBetweenOctavesAndWithinThem) {
  const GrayImage image = Noise(200, 200);
  const int num_features = ExtractSift(image).size();
  int num_polls = 0;
  ExtractSift(image, {}, [&] {
    ++num_polls;
    return false;
  });
  EXPECT_GT(num_polls, 12);  // Three octaves of six Gaussians.
  for (const int last_poll : {0, 5, num_polls - 1}) {
    int count = 0;
    const FeatureSet features = ExtractSift(image, {}, [&] { return ++count > last_poll; });
    EXPECT_LT(features.size(), num_features) << last_poll;
    EXPECT_EQ(features.descriptors.rows(), features.size());
  }
}

// The strongest are not kept: fine and contrasty texture is not what other photos see again.
TEST(ExtractSift, KeepsTheLargestFeatures) {
  const GrayImage image = Noise(200, 200);
  const FeatureSet all = ExtractSift(image);
  ASSERT_GT(all.size(), 60);
  const FeatureSet few = ExtractSift(image, {.max_features = 20});
  ASSERT_EQ(few.size(), 20);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(few.keypoints[i].x_px, all.keypoints[i].x_px);
    EXPECT_EQ(few.descriptors.row(i), all.descriptors.row(i));
  }
  // Octaves overlap by half of their width.
  const auto smaller = [](const Keypoint& a, const Keypoint& b) { return a.scale_px < b.scale_px; };
  const float smallest_kept =
      std::min_element(few.keypoints.begin(), few.keypoints.end(), smaller)->scale_px;
  for (int i = 20; i < all.size(); ++i) {
    EXPECT_LT(all.keypoints[i].scale_px, 2.0f * smallest_kept);
  }
}

TEST(ExtractSift, GivesTheSameFromManyThreads) {
  const GrayImage image = Noise(160, 120);
  const FeatureSet expected = ExtractSift(image);
  std::vector<FeatureSet> results(4);
  std::vector<std::thread> threads;
  for (FeatureSet& result : results) {
    threads.emplace_back([&] { result = ExtractSift(image); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const FeatureSet& result : results) {
    ASSERT_EQ(result.size(), expected.size());
    EXPECT_EQ(result.descriptors, expected.descriptors);
  }
}

TEST(ExtractSift, AFlatImageHasNoFeatures) {
  const FeatureSet features = ExtractSift(DrawBlobs(64, 48, {}));
  EXPECT_EQ(features.size(), 0);
  EXPECT_EQ(features.descriptors.cols(), 128);
}

// Every pixel at random, with all of the contrast that there is.
GrayImage WhiteNoise(int width_px, int height_px, uint32_t seed) {
  std::mt19937 rng(seed);
  GrayImage image{width_px, height_px, std::vector<uint8_t>(width_px * height_px)};
  for (uint8_t& pixel : image.pixels) {
    pixel = rng() % 2 == 0 ? 0 : 255;
  }
  return image;
}

void ExpectSaneFeatures(const GrayImage& image, const SiftOptions& options) {
  const FeatureSet features = ExtractSift(image, options);
  SCOPED_TRACE(::testing::Message() << image.width_px << " x " << image.height_px << ", "
                                    << options.max_pixels << " pixels");
  ValidateFeatures(features, "features");
  EXPECT_LE(features.size(), options.max_features);
  EXPECT_EQ(features.descriptors.cols(), 128);
  for (const Keypoint& keypoint : features.keypoints) {
    EXPECT_GE(keypoint.x_px, 0.0f);
    EXPECT_LE(keypoint.x_px, image.width_px);
    EXPECT_GE(keypoint.y_px, 0.0f);
    EXPECT_LE(keypoint.y_px, image.height_px);
    EXPECT_GT(keypoint.scale_px, 0.0f);
  }
  EXPECT_TRUE(
      (features.descriptors.array() >= 0.0f && features.descriptors.array() <= 255.0f).all());
}

TEST(ExtractSift, TakesImagesOfAnyShape) {
  const int sides_px[] = {1, 2, 3, 5, 15, 16, 17, 31, 32, 33, 63, 64, 65, 100};
  for (const int width_px : sides_px) {
    for (const int height_px : sides_px) {
      const GrayImage image = WhiteNoise(width_px, height_px, width_px * 1000 + height_px);
      ExpectSaneFeatures(image, {});
      ExpectSaneFeatures(image, {.max_features = 5});
      ExpectSaneFeatures(image, {.max_pixels = 7});
    }
  }
}

TEST(ExtractSift, TakesImagesOfExtremeShape) {
  for (const auto& [width_px, height_px] :
       {std::pair(1, 20'000), std::pair(20'000, 1), std::pair(7'000, 3), std::pair(9, 3'000)}) {
    const GrayImage image = WhiteNoise(width_px, height_px, 1);
    ExpectSaneFeatures(image, {});
    ExpectSaneFeatures(image, {.max_pixels = 1'000});
    ExpectSaneFeatures(image, {.max_pixels = 1});
  }
}

TEST(SiftExtractor, GivesTheFeaturesOfExtractSift) {
  const GrayImage image = DrawBlobs(140, 140, {{40, 40, 4.0}, {90, 80, 6.0}});
  const SiftOptions options = {.max_features = 2};
  const FeatureSet features = SiftExtractor(options).Extract(image);
  EXPECT_EQ(features.descriptors, ExtractSift(image, options).descriptors);
  EXPECT_EQ(features.descriptors.cols(), SiftExtractor().descriptor_dim());
  EXPECT_EQ(SiftExtractor(options).settings(), "2 3000000");
}

TEST(ExtractSift, RefusesNonsense) {
  EXPECT_THROW(ExtractSift(GrayImage{10, 10, std::vector<uint8_t>(99)}), Error);
  EXPECT_THROW(ExtractSift(GrayImage{}), Error);
  EXPECT_THROW(ExtractSift(DrawBlobs(64, 48, {}), {.max_features = 0}), Error);
  EXPECT_THROW(ExtractSift(DrawBlobs(64, 48, {}), {.max_pixels = 0}), Error);
}

}  // namespace
}  // namespace cairn
