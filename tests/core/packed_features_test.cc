#include "core/packed_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

DescriptorMatrix Values(std::initializer_list<float> values) {
  DescriptorMatrix matrix(static_cast<Eigen::Index>(values.size()) / 2, 2);
  std::copy(values.begin(), values.end(), matrix.data());
  return matrix;
}

TEST(PackedDescriptors, KeepWholeNumbersInBytes) {
  const DescriptorMatrix values = Values({0.0f, 255.0f, 7.0f, 1.0f, 3.0f, 2.0f});
  const PackedDescriptors packed = values;
  ASSERT_NE(packed.as_bytes(), nullptr);
  EXPECT_EQ(packed.as_bytes()->Load()->coeff(0, 1), 255);
  EXPECT_EQ(packed.rows(), 3);
  EXPECT_EQ(packed.cols(), 2);
  EXPECT_EQ(packed.Unpacked(), values);
  EXPECT_EQ(packed.Row(1), values.row(1));
  EXPECT_EQ(packed.Rows(std::vector<int>{2, 0}).Unpacked(), Values({3.0f, 2.0f, 0.0f, 255.0f}));
}

TEST(PackedDescriptors, KeepOtherNumbersToTheBit) {
  for (const float odd : {-0.0f, 0.5f, -1.0f, 256.0f, 1e30f}) {
    const DescriptorMatrix values = Values({1.0f, odd, 2.0f, 3.0f});
    const PackedDescriptors packed = values;
    EXPECT_EQ(packed.as_bytes(), nullptr) << odd;
    EXPECT_EQ(packed.Unpacked(), values) << odd;
    EXPECT_EQ(std::signbit(packed.Row(0)(1)), std::signbit(odd));
    EXPECT_EQ(packed.Rows(std::vector<int>{1}).Unpacked(), values.bottomRows(1));
  }
}

TEST(PackedDescriptors, ABytesValueMayBeAnother) {
  std::vector<float> squares(256);
  for (size_t i = 0; i < squares.size(); ++i) {
    squares[i] = static_cast<float>(i * i) / 512.0f;
  }
  ByteDescriptorMatrix bytes(2, 2);
  bytes << 0, 16, 255, 3;
  const PackedDescriptors packed(bytes, squares);
  EXPECT_EQ(packed.as_bytes(), nullptr);
  const DescriptorMatrix values = Values({0.0f, 0.5f, 65025.0f / 512.0f, 9.0f / 512.0f});
  EXPECT_EQ(packed.Unpacked(), values);
  EXPECT_EQ(packed.Row(1), values.row(1));
  EXPECT_EQ(packed.Rows(std::vector<int>{1}).Row(0), values.row(1));
}

TEST(PackedDescriptors, WholeNumbersAreBytesWhateverTheyWere) {
  const std::vector<float> doubled = [] {
    std::vector<float> values;
    for (int i = 0; i < 256; ++i) {
      values.push_back(static_cast<float>(2 * i));
    }
    return values;
  }();
  for (const int byte : {0, 100, 128}) {
    const PackedDescriptors packed(ByteDescriptorMatrix::Constant(1, 2, byte), doubled);
    EXPECT_EQ(packed.as_bytes() != nullptr, byte < 128);
    EXPECT_EQ(packed.Row(0)(1), 2.0f * static_cast<float>(byte));
  }
  EXPECT_NE(PackedDescriptors(ByteDescriptorMatrix(0, 2), doubled).as_bytes(), nullptr);
}

TEST(PackedDescriptors, NoRowsKeepTheirDimension) {
  for (const float value : {1.0f, 0.5f}) {
    const PackedDescriptors none = PackedDescriptors(Values({value, 2.0f})).Rows({});
    EXPECT_EQ(none.rows(), 0);
    EXPECT_EQ(none.cols(), 2);
  }
  EXPECT_EQ(PackedDescriptors().rows(), 0);
}

TEST(PackedFeatures, AreThoseOfTheSet) {
  FeatureSet set;
  set.keypoints = {{1.0f, 2.0f}, {3.0f, 4.0f}};
  set.descriptors = Values({0.5f, 1.0f, 2.0f, 3.0f});
  set.space = DescriptorSpace::kProjected;
  const FeatureSet same = PackedFeatures(set).Unpacked();
  EXPECT_EQ(same.keypoints[1].y_px, 4.0f);
  EXPECT_EQ(same.descriptors, set.descriptors);
  EXPECT_EQ(same.space, DescriptorSpace::kProjected);
}

TEST(PackedFeatures, AreValidatedAsASetIs) {
  FeatureSet set;
  set.keypoints = {{1.0f, 2.0f}};
  set.descriptors = Values({0.5f, 1.0f});
  EXPECT_NO_THROW(ValidateFeatures(PackedFeatures(set), "photo"));
  PackedFeatures more = set;
  more.keypoints.emplace_back();
  EXPECT_THROW(ValidateFeatures(more, "photo"), Error);
  set.descriptors(0, 1) = std::numeric_limits<float>::infinity();
  EXPECT_THROW(ValidateFeatures(PackedFeatures(set), "photo"), Error);
}

}  // namespace
}  // namespace cairn
