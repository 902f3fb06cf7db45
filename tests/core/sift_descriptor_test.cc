// Compares orientations and descriptors with classic SIFT in plain loops and double precision.
#include "core/features/sift/sift_descriptor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/angles.h"
#include "core/features/sift/arc_tangent.h"
#include "core/features/sift/sift_orientation.h"

namespace cairn {
namespace {

using Descriptor = std::array<float, kSiftDim>;

// Blotches of all sizes.
ScaleSpaceOctave SomeOctave() {
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> gray(0.0f, 255.0f);
  FloatImage image(320, 240);
  for (int row = 0; row < 240; ++row) {
    std::generate_n(image.Row(row), 320, [&] { return gray(rng); });
  }
  return MakeScaleSpaceOctave(image, 0.5);
}

// Every pixel of the window adds to the eight cells around it.
class PlainDescriptor {
 public:
  PlainDescriptor(const FloatImage& gaussian, const SiftExtremum& extremum, double angle_rad) {
    const double cell_px = 3.0 * extremum.sigma_px;
    for (int y = 1; y < gaussian.height_px() - 1; ++y) {
      for (int x = 1; x < gaussian.width_px() - 1; ++x) {
        const double dx = (x - extremum.x_px) / cell_px, dy = (y - extremum.y_px) / cell_px;
        const double c = std::cos(angle_rad), s = std::sin(angle_rad);
        const double along = c * dx + s * dy, across = -s * dx + c * dy;
        if (std::max(std::abs(along), std::abs(across)) > 2.5) {
          continue;
        }
        const double gx = gaussian.Row(y)[x + 1] - gaussian.Row(y)[x - 1];
        const double gy = gaussian.Row(y + 1)[x] - gaussian.Row(y - 1)[x];
        const double turned = angle_rad - std::atan2(gy, gx);
        const double direction = turned / (2.0 * kPi) * 8.0;
        Add(along + 1.5, across + 1.5, direction - 8.0 * std::floor(direction / 8.0),
            std::hypot(gx, gy) * std::exp(-0.125 * (along * along + across * across)));
      }
    }
  }

  Descriptor Normalized() const {
    std::array<double, kSiftDim> values = values_;
    const auto norm = [&] {
      double sum = 0.0;
      for (const double value : values) {
        sum += value * value;
      }
      return std::sqrt(sum);
    };
    const double first_norm = norm();
    for (double& value : values) {
      value = std::min(value, 0.2 * first_norm);
    }
    const double second_norm = norm();
    Descriptor descriptor;
    for (int i = 0; i < kSiftDim; ++i) {
      descriptor[i] = static_cast<float>(512.0 * values[i] / second_norm);
    }
    return descriptor;
  }

 private:
  void Add(double column, double row, double direction, double weight) {
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) {
        const double near =
            std::max(0.0, 1.0 - std::abs(row - r)) * std::max(0.0, 1.0 - std::abs(column - c));
        for (int d = 0; d < 8; ++d) {
          const double apart = std::min(std::abs(direction - d), 8.0 - std::abs(direction - d));
          values_[(4 * r + c) * 8 + d] += weight * near * std::max(0.0, 1.0 - apart);
        }
      }
    }
  }

  std::array<double, kSiftDim> values_ = {};
};

std::vector<SiftExtremum> SomeExtrema(const ScaleSpaceOctave& octave) {
  std::vector<SiftExtremum> extrema = DetectSiftExtrema(octave, {.contrast_threshold = 0.0});
  std::erase_if(extrema, [](const SiftExtremum& e) {
    return e.x_px < 50 || e.x_px > 270 || e.y_px < 50 || e.y_px > 190;
  });
  return extrema;
}

TEST(DescribeSift, IsNearTheDescriptorOfAllPixels) {
  const ScaleSpaceOctave octave = SomeOctave();
  const std::vector<SiftExtremum> extrema = SomeExtrema(octave);
  ASSERT_GT(extrema.size(), 5u);
  for (const SiftExtremum& extremum : extrema) {
    for (const float angle_rad : {0.0f, 1.0f, -2.5f}) {
      Descriptor descriptor;
      DescribeSift(octave, extremum, angle_rad, descriptor);
      const Descriptor plain =
          PlainDescriptor(octave.Level(extremum.level), extremum, angle_rad).Normalized();
      double sq_distance = 0.0;
      for (int i = 0; i < kSiftDim; ++i) {
        sq_distance += (descriptor[i] - plain[i]) * (descriptor[i] - plain[i]);
      }
      // Of a length of 512. Descriptors of different places are 500 apart and more.
      EXPECT_LT(std::sqrt(sq_distance), 60.0) << extremum.sigma_px;
    }
  }
}

TEST(DescribeSift, AFlatSurroundingHasNoGradients) {
  ScaleSpaceOctave octave;
  octave.gaussians.resize(kSiftLevelsPerOctave + 3);
  for (FloatImage& gaussian : octave.gaussians) {
    gaussian = FloatImage(40, 40);
    for (int row = 0; row < 40; ++row) {
      std::fill_n(gaussian.Row(row), 40, 90.0f);
    }
  }
  const SiftExtremum extremum{.x_px = 20.0f, .y_px = 20.0f, .sigma_px = 2.0f, .level = 1};
  Descriptor descriptor;
  DescribeSift(octave, extremum, 0.5f, descriptor);
  EXPECT_EQ(descriptor, Descriptor{});
  EXPECT_EQ(FindSiftOrientations(octave, extremum).num, 0);
}

TEST(FindSiftOrientations, FollowsARamp) {
  for (const double angle_rad : {0.1, 1.2, 2.9, 4.0, 6.0}) {
    FloatImage image(60, 60);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 60; ++x) {
        image.Row(y)[x] =
            static_cast<float>(120.0 + 2.0 * (std::cos(angle_rad) * x + std::sin(angle_rad) * y));
      }
    }
    const SiftOrientations orientations =
        FindSiftOrientations(MakeScaleSpaceOctave(image, 0.5),
                             {.x_px = 30.0f, .y_px = 30.0f, .sigma_px = 2.5f, .level = 2});
    ASSERT_EQ(orientations.num, 1);
    EXPECT_NEAR(orientations.angles_rad[0], angle_rad, 0.01);
  }
}

TEST(DirectionInEighths, IsTheArcTangent) {
  for (int i = 0; i < 1000; ++i) {
    const double angle_rad = 2.0 * kPi * i / 1000.0;
    const auto y = static_cast<float>(std::sin(angle_rad));
    const auto x = static_cast<float>(std::cos(angle_rad));
    EXPECT_NEAR(DirectionInEighths(y, x), angle_rad * 4.0 / kPi, 2e-4);
  }
  EXPECT_EQ(DirectionInEighths(0.0f, 0.0f), 0.0f);
}

}  // namespace
}  // namespace cairn
