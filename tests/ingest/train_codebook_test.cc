#include "ingest/codebook/train_codebook.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "storage/codebook/descriptor_codec.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

const Reconstruction& TrainingStreet() {
  static const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  return reconstruction;
}

const Codebook& StreetCodebook() {
  static const Codebook codebook = TrainCodebook(TrainingStreet(), {});
  return codebook;
}

// All normalized descriptors of the street's images.
DescriptorMatrix NormalizedDescriptors() {
  DescriptorMatrix descriptors = TrainingStreet().images[3].features.descriptors.Unpacked();
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &descriptors);
  return descriptors;
}

TEST(TrainCodebook, HasTheShapesAskedFor) {
  const Codebook& codebook = StreetCodebook();
  EXPECT_EQ(codebook.raw_dim(), 128);
  EXPECT_EQ(codebook.projected_dim(), 16);
  EXPECT_EQ(codebook.num_subspaces, 8);
  EXPECT_EQ(codebook.words.size(), 8u * 256u * 2u);
  EXPECT_EQ(codebook.descriptor_type, "sift");
  EXPECT_NO_THROW(codebook.Validate());
}

TEST(TrainCodebook, ProjectionIsOrthonormal) {
  const DescriptorMatrix& projection = StreetCodebook().projection;
  const Eigen::MatrixXf gram = projection * projection.transpose();
  EXPECT_LT((gram - Eigen::MatrixXf::Identity(16, 16)).cwiseAbs().maxCoeff(), 1e-5f);
}

TEST(TrainCodebook, ProjectionKeepsMoreVarianceThanAnySixteenBins) {
  const DescriptorMatrix normalized = NormalizedDescriptors();
  const DescriptorMatrix centered = normalized.rowwise() - normalized.colwise().mean();
  const double kept = (centered * StreetCodebook().projection.transpose()).squaredNorm();
  std::vector<double> bins(128);
  for (int i = 0; i < 128; ++i) {
    bins[i] = centered.col(i).squaredNorm();
  }
  std::sort(bins.rbegin(), bins.rend());
  double best_bins = 0.0;
  for (int i = 0; i < 16; ++i) {
    best_bins += bins[i];
  }
  EXPECT_GT(kept, best_bins);
}

// Squared projected distance between looks at one landmark over that between landmarks.
double SameOverOther(const Codebook& codebook) {
  const DescriptorCodec codec(std::make_shared<const Codebook>(codebook));
  double same = 0.0, other = 0.0;
  Eigen::RowVectorXf previous;
  for (const ReconLandmark& landmark : TrainingStreet().landmarks) {
    DescriptorMatrix raw(2, 128);
    for (int i = 0; i < 2; ++i) {
      const ReconObservation& observation = landmark.observations[i];
      raw.row(i) = TrainingStreet().images[observation.image_idx].features.descriptors.Row(
          observation.keypoint_idx);
    }
    const DescriptorMatrix projected = codec.Project(raw);
    same += (projected.row(0) - projected.row(1)).squaredNorm();
    if (previous.size() > 0) {
      other += (projected.row(0) - previous).squaredNorm();
    }
    previous = projected.row(0);
  }
  return same / other;
}

TEST(TrainCodebook, TheLikelihoodRatioTellsLandmarksApartAtLeastAsWell) {
  CodebookOptions options;
  options.projection = ProjectionKind::kLikelihoodRatio;
  const Codebook codebook = TrainCodebook(TrainingStreet(), options);
  EXPECT_NO_THROW(codebook.Validate());
  EXPECT_LE(SameOverOther(codebook), SameOverOther(StreetCodebook()));
}

TEST(TrainCodebook, BalancesTheVarianceOfSubspaces) {
  const DescriptorCodec codec(std::make_shared<const Codebook>(StreetCodebook()));
  const DescriptorMatrix projected =
      codec.Project(TrainingStreet().images[3].features.descriptors.Unpacked());
  const Eigen::RowVectorXf mean = projected.colwise().mean();
  std::vector<double> products;
  for (int s = 0; s < 8; ++s) {
    const auto piece = (projected.rowwise() - mean).middleCols(2 * s, 2);
    products.push_back(piece.col(0).squaredNorm() * piece.col(1).squaredNorm());
  }
  const auto [smallest, largest] = std::minmax_element(products.begin(), products.end());
  EXPECT_LT(*largest, 4.0 * *smallest);
}

TEST(TrainCodebook, QuantizesWithLittleLoss) {
  const DescriptorCodec codec(std::make_shared<const Codebook>(StreetCodebook()));
  const DescriptorMatrix projected =
      codec.Project(TrainingStreet().images[3].features.descriptors.Unpacked());
  const DescriptorMatrix decoded =
      codec.Decode(codec.Encode(projected).data(), static_cast<int>(projected.rows()));
  EXPECT_LT((projected - decoded).squaredNorm(), 0.1f * projected.squaredNorm());
}

TEST(TrainCodebook, QuantilesRiseAndTellLandmarksApart) {
  const Codebook& codebook = StreetCodebook();
  const auto& same = codebook.same_landmark_distance_quantiles;
  const auto& other = codebook.other_landmark_distance_quantiles;
  ASSERT_EQ(same.size(), 19u);
  ASSERT_EQ(other.size(), 19u);
  EXPECT_TRUE(std::is_sorted(same.begin(), same.end()));
  EXPECT_TRUE(std::is_sorted(other.begin(), other.end()));
  EXPECT_GT(same.front(), 0.0f);
  EXPECT_LT(same[9], other[9]);
}

TEST(TrainCodebook, IsDeterministicBySeedOnAnyNumberOfThreads) {
  CodebookOptions options;
  options.max_training_descriptors = 2000;  // A sample, so that the seed matters.
  omp_set_num_threads(1);
  const std::vector<uint8_t> one = EncodeCodebook(TrainCodebook(TrainingStreet(), options));
  omp_set_num_threads(2);
  EXPECT_EQ(EncodeCodebook(TrainCodebook(TrainingStreet(), options)), one);
  options.seed = 2;
  EXPECT_NE(EncodeCodebook(TrainCodebook(TrainingStreet(), options)), one);
}

TEST(TrainCodebook, RefusesTooFewDescriptors) {
  Reconstruction few = TrainingStreet();
  few.landmarks.resize(20);
  EXPECT_THROW(TrainCodebook(few, {}), Error);
}

TEST(TrainCodebook, RefusesAProjectionToMoreDimensions) {
  testing::StreetWorldOptions options;
  options.descriptor_dim = 8;
  EXPECT_THROW(TrainCodebook(testing::StreetWorld(options).Reconstruct(), {}), Error);
}

TEST(CodebookOptions, RefusesSubspacesThatDoNotDivide) {
  CodebookOptions options;
  options.num_subspaces = 5;
  EXPECT_THROW(options.Validate(), Error);
}

}  // namespace
}  // namespace cairn
