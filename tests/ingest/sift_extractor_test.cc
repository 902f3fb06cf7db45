#include "ingest/features/sift_extractor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

struct Blob {
  double x_px, y_px, sigma_px;
};

// Gaussian blobs on grey; positions in our pixel convention.
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

TEST(ExtractSift, PutsKeypointsOnTheCentresOfBlobs) {
  const std::vector<Blob> blobs = {
      {40.5, 40.5, 3.0}, {90.0, 40.25, 4.0}, {40.8, 90.3, 3.5}, {95.3, 95.7, 5.0}};
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
                 std::abs(WrapAngleRad(b.orientation_rad - a.orientation_rad -
                                       std::numbers::pi / 2.0)) < 0.1;
        });
  }
  // Round blobs leave some orientations to chance.
  EXPECT_GT(num_found, features.size() / 2);
}

TEST(ExtractSift, HalvedImagesGiveKeypointsInTheOriginalsPixels) {
  const std::vector<Blob> blobs = {{101.0, 102.0, 8.0}, {60.0, 150.0, 10.0}};
  const GrayImage image = DrawBlobs(201, 205, blobs);  // Odd sides do not halve exactly.
  const FeatureSet features = ExtractSift(image, {.max_pixels = 15'000});
  for (const Blob& blob : blobs) {
    const Keypoint& keypoint = Nearest(features, blob);
    EXPECT_NEAR(keypoint.x_px, blob.x_px, 0.15);
    EXPECT_NEAR(keypoint.y_px, blob.y_px, 0.15);
    EXPECT_NEAR(keypoint.scale_px / blob.sigma_px, 0.95, 0.15);
  }
}

TEST(ExtractSift, KeepsTheStrongestFeatures) {
  const GrayImage image = Noise(200, 200);
  const FeatureSet all = ExtractSift(image);
  ASSERT_GT(all.size(), 25);
  const FeatureSet few = ExtractSift(image, {.max_features = 20});
  ASSERT_EQ(few.size(), 20);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(few.keypoints[i].x_px, all.keypoints[i].x_px);
    EXPECT_EQ(few.descriptors.row(i), all.descriptors.row(i));
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
  for (std::thread& thread : threads) thread.join();
  for (const FeatureSet& result : results) {
    ASSERT_EQ(result.size(), expected.size());
    EXPECT_EQ(result.descriptors, expected.descriptors);
  }
}

TEST(ExtractSift, AFlatImageHasNoFeatures) {
  const FeatureSet features = ExtractSift(DrawBlobs(64, 48, {}));
  EXPECT_EQ(features.size(), 0);
  EXPECT_EQ(features.descriptors.cols(), 128);
  EXPECT_EQ(ExtractSift(DrawBlobs(1, 1, {})).size(), 0);
}

TEST(ExtractSift, RefusesNonsense) {
  EXPECT_THROW(ExtractSift(GrayImage{10, 10, std::vector<uint8_t>(99)}), Error);
  EXPECT_THROW(ExtractSift(GrayImage{}), Error);
  EXPECT_THROW(ExtractSift(DrawBlobs(64, 48, {}), {.max_features = 0}), Error);
}

}  // namespace
}  // namespace cairn
