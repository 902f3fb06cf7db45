#include "storage/tile/tile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"
#include "storage/tile/morton.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

TEST(OrientationCode, RoundTripsEveryCodeThatIsWritten) {
  for (int code = 0; code < 256; code += kOrientationCodeStep) {
    const double angle_rad = OrientationFromCode(static_cast<uint8_t>(code));
    EXPECT_GT(angle_rad, -kPi);
    EXPECT_LE(angle_rad, kPi);
    EXPECT_EQ(OrientationCode(angle_rad), code);
    EXPECT_EQ(OrientationCode(angle_rad + 4.0 * kPi), code);
  }
  EXPECT_EQ(OrientationCode(0.0), 0);
  EXPECT_EQ(OrientationFromCode(128), kPi);
}

TEST(OrientationCode, RoundsToTheNearestStepAndNeverMeansNone) {
  for (double angle_rad = -7.0; angle_rad < 7.0; angle_rad += 0.001) {
    const uint8_t code = OrientationCode(angle_rad);
    ASSERT_NE(code, kNoOrientation) << angle_rad;
    const double error_rad = std::remainder(OrientationFromCode(code) - angle_rad, 2.0 * kPi);
    ASSERT_LE(std::abs(error_rad), kOrientationCodeStep * kPi / 256.0 + 1e-12);
  }
}

TEST(AzimuthCode, RoundTripsEveryCodeThatIsWrittenAndRounds) {
  for (int code = 0; code < 256; code += kAzimuthCodeStep) {
    EXPECT_EQ(AzimuthCode(AzimuthFromCode(static_cast<uint8_t>(code))), code);
  }
  for (double azimuth_rad = -6.0; azimuth_rad < 6.0; azimuth_rad += 0.01) {
    const double error_rad =
        std::remainder(AzimuthFromCode(AzimuthCode(azimuth_rad)) - azimuth_rad, 2.0 * kPi);
    ASSERT_LE(std::abs(error_rad), kAzimuthCodeStep * kPi / 256.0 + 1e-12);
  }
}

TEST(SizeCode, CoversAMillimeterToSixtyMetersInEqualRatios) {
  EXPECT_DOUBLE_EQ(SizeFromCode(0), 1e-3);
  EXPECT_NEAR(SigmaFromCode(255), 60.0, 1e-9);
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(SigmaCode(SigmaFromCode(static_cast<uint8_t>(code))), code);
  }
  for (int code = 0; code < 255; ++code) {
    EXPECT_LE(std::abs(SizeCode(SizeFromCode(static_cast<uint8_t>(code))) - code),
              kSizeCodeStep / 2);
  }
  EXPECT_NEAR(SizeFromCode(101) / SizeFromCode(100), 1.044, 0.001);
}

TEST(SizeCode, ThatIsUnknownStaysUnknown) {
  EXPECT_EQ(SizeFromCode(SizeCode(0.0)), 0.0);
  EXPECT_GT(SizeFromCode(SizeCode(1e-9)), 0.0);
  EXPECT_GT(SizeFromCode(SizeCode(1e9)), 59.0 / 1.2);
}

TEST(SizeCode, IsStableOnceRounded) {
  for (int code = 0; code < 256; code += kSizeCodeStep) {
    EXPECT_EQ(SizeCode(SizeFromCode(static_cast<uint8_t>(code))), code);
  }
}

TEST(SizeCode, ClampsWhatIsOutside) {
  EXPECT_EQ(SizeCode(1e-9), 0);
  EXPECT_EQ(SizeCode(INFINITY), 252);
}

TEST(QuantizePosition, RoundsToTheNearestStep) {
  const Eigen::Vector3d x_in_tile(12.3456, -70.001, 3.0 / 512.0);
  const Eigen::Vector3f quantized = QuantizePosition(x_in_tile);
  EXPECT_LE((quantized.cast<double>() - x_in_tile).cwiseAbs().maxCoeff(),
            0.5 * Tile::kPositionStepM);
  EXPECT_EQ(QuantizePosition(quantized.cast<double>()), quantized);
}

TEST(QuantizePosition, ClampsToTheRangeOfATile) {
  const Eigen::Vector3f clamped = QuantizePosition({1e6, -1e6, 0.0});
  EXPECT_EQ(clamped, Eigen::Vector3f(4096.0f - 1.0f / 256.0f, -4096.0f, 0.0f));
}

TEST(Morton, RoundTripsPositions) {
  for (const Eigen::Vector3d& x_in_tile :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-4096, 4095.99609375, 1),
        Eigen::Vector3d(74.5, -33.25, 0.00390625)}) {
    const Eigen::Vector3f position = QuantizePosition(x_in_tile);
    EXPECT_EQ(PositionFromMorton(MortonFromPosition(position)), position);
  }
  EXPECT_EQ(MortonFromPosition({-4096.0f, -4096.0f, -4096.0f}), 0u);
  EXPECT_EQ(MortonFromPosition(QuantizePosition({1e9, 1e9, 1e9})), ~uint64_t{0} >> 1);
}

TEST(Morton, OrderIsAPermutationThatKeepsEqualsInOrder) {
  const std::vector<Eigen::Vector3f> positions = {
      {1, 1, 1}, {-1, -1, -1}, {0, 0, 0}, {-1, -1, -1}, {1, 0, 0}};
  EXPECT_THAT(MortonOrder(positions), ::testing::ElementsAre(1, 3, 2, 4, 0));
}

TEST(Tile, MemoryCountsItsArrays) {
  testing::RandomTileOptions options;
  options.num_landmarks = 10;
  const size_t small = testing::RandomTile(options).MemoryBytes();
  options.num_landmarks = 1000;
  const size_t large = testing::RandomTile(options).MemoryBytes();
  EXPECT_GT(large, small + 990 * (8 + 8 + 12 + 1 + 4 + 8 + 3));
  EXPECT_EQ(Tile().MemoryBytes(), 0u);
}

}  // namespace
}  // namespace cairn
