#include "core/features/sift/gaussian_blur.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/features/sift/scale_space.h"

namespace cairn {
namespace {

FloatImage RandomImage(int width_px, int height_px) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> gray(0.0f, 255.0f);
  FloatImage image(width_px, height_px);
  for (int row = 0; row < height_px; ++row) {
    std::generate_n(image.Row(row), width_px, [&] { return gray(rng); });
  }
  return image;
}

// By the definition, in double, as far as the weights are worth a thought.
double PlainBlur(const FloatImage& image, double sigma_px, int x, int y) {
  const int reach = static_cast<int>(std::ceil(5.0 * sigma_px));
  double sum = 0.0, sum_of_weights = 0.0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double weight = std::exp(-0.5 * (dx * dx + dy * dy) / (sigma_px * sigma_px));
      sum += weight *
             image.Row(std::clamp(
                 y + dy, 0, image.height_px() - 1))[std::clamp(x + dx, 0, image.width_px() - 1)];
      sum_of_weights += weight;
    }
  }
  return sum / sum_of_weights;
}

TEST(GaussianBlur, IsTheGaussianOfItsDefinition) {
  for (const auto& [width_px, height_px] : {std::pair(37, 29), std::pair(70, 5), std::pair(1, 9)}) {
    const FloatImage image = RandomImage(width_px, height_px);
    for (const double sigma_px : {0.8, 1.5, 1.9, 2.5, 3.1}) {
      const FloatImage blurred = GaussianBlur(image, sigma_px);
      for (int y = 0; y < height_px; ++y) {
        for (int x = 0; x < width_px; ++x) {
          // What lies beyond three sigmas.
          EXPECT_NEAR(blurred.Row(y)[x], PlainBlur(image, sigma_px, x, y), 0.6)
              << sigma_px << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST(GaussianBlur, KeepsAFlatImage) {
  FloatImage image(20, 20);
  for (int row = 0; row < 20; ++row) {
    std::fill_n(image.Row(row), 20, 77.0f);
  }
  const FloatImage blurred = GaussianBlur(image, 2.0);
  for (int row = 0; row < 20; ++row) {
    for (int x = 0; x < 20; ++x) {
      EXPECT_NEAR(blurred.Row(row)[x], 77.0f, 1e-4f);
    }
  }
}

// A blur of sigma and then halving: variances add, and every second pixel remains.
TEST(FloatImage, HalvingIsABlurOfTheVarianceThatItNames) {
  const FloatImage image = GaussianBlur(RandomImage(64, 48), 2.0);
  const FloatImage half = Halve(image);
  ASSERT_EQ(half.width_px(), 32);
  ASSERT_EQ(half.height_px(), 24);
  for (int y = 4; y < 20; ++y) {
    for (int x = 4; x < 28; ++x) {
      EXPECT_NEAR(half.Row(y)[x], PlainBlur(image, std::sqrt(kHalvingVariancePx2), 2 * x, 2 * y),
                  0.2);
    }
  }
}

TEST(FloatImage, HalvingRoundsUp) {
  const FloatImage half = Halve(RandomImage(7, 1));
  EXPECT_EQ(half.width_px(), 4);
  EXPECT_EQ(half.height_px(), 1);
}

TEST(FloatImage, DoublingKeepsPixelsAndPutsMeansBetween) {
  const FloatImage image = RandomImage(5, 3);
  const FloatImage twice = Double(image);
  ASSERT_EQ(twice.width_px(), 10);
  ASSERT_EQ(twice.height_px(), 6);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      EXPECT_EQ(twice.Row(2 * y)[2 * x], image.Row(y)[x]);
    }
  }
  EXPECT_FLOAT_EQ(twice.Row(0)[1], 0.5f * (image.Row(0)[0] + image.Row(0)[1]));
  EXPECT_FLOAT_EQ(twice.Row(3)[4], 0.5f * (image.Row(1)[2] + image.Row(2)[2]));
  EXPECT_EQ(twice.Row(5)[9], image.Row(2)[4]);
}

}  // namespace
}  // namespace cairn
