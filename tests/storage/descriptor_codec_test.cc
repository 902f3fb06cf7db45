#include "storage/codebook/descriptor_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "core/error.h"
#include "support/map_builder.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::RandomCodebook;

DescriptorMatrix RandomDescriptors(int count, int dim, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  return DescriptorMatrix::NullaryExpr(count, dim, [&] { return normal(random); });
}

// The nearest word by definition.
uint8_t NearestWordOf(const Codebook& codebook, const DescriptorMatrix& projected, int row, int s) {
  const int dim = codebook.subspace_dim();
  double best = std::numeric_limits<double>::infinity();
  int best_word = 0;
  for (int word = 0; word < Codebook::kNumWords; ++word) {
    double sq_dist = 0.0;
    for (int d = 0; d < dim; ++d) {
      const double difference = double{projected(row, s * dim + d)} -
                                codebook.words[(s * Codebook::kNumWords + word) * dim + d];
      sq_dist += difference * difference;
    }
    if (sq_dist < best) {
      best = sq_dist;
      best_word = word;
    }
  }
  return static_cast<uint8_t>(best_word);
}

TEST(DescriptorCodec, EncodesToTheNearestWords) {
  for (const int num_subspaces : {1, 4, 8, 16}) {
    const auto codebook =
        std::make_shared<const Codebook>(RandomCodebook({.num_subspaces = num_subspaces}));
    const DescriptorMatrix projected = RandomDescriptors(200, 16, 7);
    const std::vector<uint8_t> codes = DescriptorCodec(codebook).Encode(projected);
    ASSERT_EQ(codes.size(), 200u * num_subspaces);
    for (int row = 0; row < 200; ++row) {
      for (int s = 0; s < num_subspaces; ++s) {
        ASSERT_EQ(codes[row * num_subspaces + s], NearestWordOf(*codebook, projected, row, s))
            << num_subspaces << " subspaces, descriptor " << row;
      }
    }
  }
}

TEST(DescriptorCodec, EncodeInvertsDecode) {
  const DescriptorCodec codec(std::make_shared<const Codebook>(RandomCodebook()));
  std::vector<uint8_t> codes(8 * 256);
  for (int i = 0; i < 256; ++i) {
    std::fill_n(codes.begin() + 8 * i, 8, static_cast<uint8_t>(i));
  }
  EXPECT_EQ(codec.Encode(codec.Decode(codes.data(), 256)), codes);
}

TEST(DescriptorCodec, EqualWordsGiveTheLowestIndex) {
  Codebook codebook = RandomCodebook();
  std::fill(codebook.words.begin(), codebook.words.end(), 0.5f);
  const DescriptorCodec codec(std::make_shared<const Codebook>(codebook));
  EXPECT_EQ(codec.Encode(RandomDescriptors(3, 16, 1)), std::vector<uint8_t>(24, 0));
}

TEST(DescriptorCodec, ProjectsByDefinition) {
  const auto codebook = std::make_shared<const Codebook>(RandomCodebook());
  const DescriptorCodec codec(codebook);
  const DescriptorMatrix raw = RandomDescriptors(5, 128, 3).cwiseAbs();
  const DescriptorMatrix projected = codec.Project(raw);
  for (int row = 0; row < 5; ++row) {
    const Eigen::VectorXf root =
        (raw.row(row) / raw.row(row).sum()).cwiseSqrt().transpose() - codebook->mean;
    EXPECT_TRUE(projected.row(row).transpose().isApprox(codebook->projection * root, 1e-4f));
  }
}

TEST(DescriptorCodec, ProjectedFeaturesPassThrough) {
  const DescriptorCodec codec(std::make_shared<const Codebook>(RandomCodebook()));
  FeatureSet features;
  features.space = DescriptorSpace::kProjected;
  features.descriptors = RandomDescriptors(2, 16, 1);
  EXPECT_EQ(codec.ProjectFeatures(features), features.descriptors);
  features.space = DescriptorSpace::kRaw;
  EXPECT_EQ(ErrorCodeOf([&] { codec.ProjectFeatures(features); }), ErrorCode::kBadInput);
}

TEST(DescriptorCodec, WrongDimensionsAreNamed) {
  const DescriptorCodec codec(std::make_shared<const Codebook>(RandomCodebook()));
  try {
    codec.Project(RandomDescriptors(2, 64, 1));
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("64"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("128"));
  }
  EXPECT_EQ(ErrorCodeOf([&] { codec.Encode(RandomDescriptors(2, 15, 1)); }), ErrorCode::kBadInput);
  EXPECT_TRUE(codec.Encode(RandomDescriptors(0, 16, 1)).empty());
}

TEST(DescriptorCodec, RootSiftHasUnitLengthAndZerosStayZero) {
  DescriptorMatrix descriptors = RandomDescriptors(3, 128, 5).cwiseAbs();
  descriptors.row(1).setZero();
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &descriptors);
  EXPECT_NEAR(descriptors.row(0).norm(), 1.0f, 1e-5f);
  EXPECT_EQ(descriptors.row(1).norm(), 0.0f);
  const DescriptorMatrix before = descriptors;
  NormalizeDescriptors(DescriptorNormalization::kNone, &descriptors);
  EXPECT_EQ(descriptors, before);
}

}  // namespace
}  // namespace cairn
