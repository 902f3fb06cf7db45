#include "mapping/matching/match_descriptors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace cairn {
namespace {

ByteDescriptorMatrix RandomDescriptors(int count, uint64_t seed) {
  Random random(seed);
  ByteDescriptorMatrix descriptors(count, 128);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < 128; ++j) {
      descriptors(i, j) = static_cast<uint8_t>(random.Index(4) == 0 ? random.Index(160) : 0);
    }
  }
  return descriptors;
}

ByteDescriptorMatrix Disturbed(ByteDescriptorMatrix descriptors, int noise, uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < descriptors.rows(); ++i) {
    for (int j = 0; j < descriptors.cols(); ++j) {
      const int value = descriptors(i, j) + random.Index(2 * noise + 1) - noise;
      descriptors(i, j) = static_cast<uint8_t>(std::clamp(value, 0, 255));
    }
  }
  return descriptors;
}

TEST(MatchDescriptors, FindsDisturbedCopiesAndNothingElse) {
  const ByteDescriptorMatrix a = RandomDescriptors(70, 1);
  ByteDescriptorMatrix b(90, 128);
  b.topRows(40) = RandomDescriptors(40, 2);
  b.bottomRows(50) = Disturbed(a.topRows(50), 8, 3);
  const auto matches = MatchDescriptors({a}, {b}, {});
  ASSERT_EQ(matches.size(), 50u);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(matches[i].a_idx, i);
    EXPECT_EQ(matches[i].b_idx, 40 + i);
    const Eigen::RowVectorXd p =
        (a.row(i).cast<double>() / a.row(i).cast<double>().sum()).cwiseSqrt();
    const Eigen::RowVectorXd q =
        (b.row(40 + i).cast<double>() / b.row(40 + i).cast<double>().sum()).cwiseSqrt();
    EXPECT_NEAR(matches[i].distance, (p - q).norm(), 0.01);
  }
}

TEST(MatchDescriptors, LeavesOutWhatOccursTwice) {
  const ByteDescriptorMatrix a = RandomDescriptors(30, 1);
  ByteDescriptorMatrix b(60, 128);
  b << Disturbed(a, 8, 2), Disturbed(a, 8, 2);
  EXPECT_TRUE(MatchDescriptors({a}, {b}, {}).empty());
  EXPECT_TRUE(MatchDescriptors({b}, {a}, {}).empty());
}

// SIFT describes a corner at several scales and orientations: twins at one place are no copies.
TEST(MatchDescriptors, KeepsWhatIsDescribedTwiceAtOnePlace) {
  const ByteDescriptorMatrix a = RandomDescriptors(30, 1);
  ByteDescriptorMatrix b(60, 128);
  b << Disturbed(a, 8, 2), Disturbed(a, 8, 2);
  std::vector<Keypoint> of_a, near_by, apart;
  for (int i = 0; i < 60; ++i) {
    const float x_px = 40.0f * static_cast<float>(i % 30);
    near_by.push_back({x_px, i < 30 ? 100.0f : 104.0f, 2.0f, 0.0f});
    apart.push_back({x_px, i < 30 ? 100.0f : 300.0f, 2.0f, 0.0f});
  }
  of_a.assign(apart.begin(), apart.begin() + 30);
  EXPECT_EQ(MatchDescriptors({a, of_a}, {b, near_by}, {}).size(), 30u);
  EXPECT_EQ(MatchDescriptors({b, near_by}, {a, of_a}, {}).size(), 30u);
  EXPECT_TRUE(MatchDescriptors({a, of_a}, {b, apart}, {}).empty());
  EXPECT_TRUE(MatchDescriptors({b, apart}, {a, of_a}, {}).empty());
}

TEST(MatchDescriptors, TakesPhotosWithoutFeatures) {
  const ByteDescriptorMatrix a = RandomDescriptors(3, 1);
  EXPECT_TRUE(MatchDescriptors({a}, {ByteDescriptorMatrix(0, 128)}, {}).empty());
  EXPECT_TRUE(MatchDescriptors({ByteDescriptorMatrix(0, 0)}, {a}, {}).empty());
  EXPECT_EQ(MatchDescriptors({a.topRows(1)}, {a}, {}).size(), 1u);
}

}  // namespace
}  // namespace cairn
