#include <gtest/gtest.h>

#include <random>
#include <set>

#include "core/error.h"
#include "ingest/tiles/appearance.h"
#include "ingest/tiles/landmark_selection.h"

namespace cairn {
namespace {

// Three well-separated groups of five descriptors.
DescriptorMatrix ThreeGroups() {
  std::mt19937_64 rng(1);
  std::normal_distribution<float> noise(0.0f, 0.01f);
  DescriptorMatrix descriptors(15, 4);
  for (int i = 0; i < 15; ++i) {
    for (int d = 0; d < 4; ++d) {
      descriptors(i, d) = noise(rng) + (d == i % 3 ? 1.0f : 0.0f);
    }
  }
  return descriptors;
}

TEST(KMeansSummarizer, KeepsTheRatioWithinItsBounds) {
  const auto summarizer = MakeKMeansSummarizer({.ratio = 0.25, .min_count = 2, .max_count = 5});
  EXPECT_EQ(summarizer->NumModes(1), 1);  // Never more than there are.
  EXPECT_EQ(summarizer->NumModes(4), 2);
  EXPECT_EQ(summarizer->NumModes(12), 3);
  EXPECT_EQ(summarizer->NumModes(100), 5);
}

TEST(KMeansSummarizer, FindsTheGroups) {
  const DescriptorMatrix descriptors = ThreeGroups();
  const AppearanceModes modes = MakeKMeansSummarizer({.ratio = 0.2})->Summarize(descriptors);
  ASSERT_EQ(modes.centers.rows(), 3);
  EXPECT_EQ(std::set<int>(modes.mode_of_descriptor.begin(), modes.mode_of_descriptor.end()).size(),
            3u);
  for (int i = 3; i < 15; ++i) {
    EXPECT_EQ(modes.mode_of_descriptor[i], modes.mode_of_descriptor[i % 3]);
  }
  for (int i = 0; i < 15; ++i) {
    EXPECT_LT((modes.centers.row(modes.mode_of_descriptor[i]) - descriptors.row(i)).norm(), 0.1f);
  }
}

TEST(KMeansSummarizer, OneModeIsTheMean) {
  const DescriptorMatrix descriptors = ThreeGroups();
  const AppearanceModes modes =
      MakeKMeansSummarizer({.ratio = 0.0, .max_count = 1})->Summarize(descriptors);
  ASSERT_EQ(modes.centers.rows(), 1);
  EXPECT_LT((modes.centers.row(0) - descriptors.colwise().mean()).norm(), 1e-6f);
}

TEST(KMeansSummarizer, EqualDescriptorsMakeOneMode) {
  const DescriptorMatrix descriptors = DescriptorMatrix::Constant(8, 4, 0.5f);
  const AppearanceModes modes = MakeKMeansSummarizer({.ratio = 0.5})->Summarize(descriptors);
  ASSERT_EQ(modes.centers.rows(), 1);
  EXPECT_EQ(modes.mode_of_descriptor, std::vector<int>(8, 0));
}

TEST(KMeansSummarizer, DependsOnNothingButDescriptorsAndOptions) {
  const auto summarizer = MakeKMeansSummarizer({.ratio = 0.5});
  const AppearanceModes first = summarizer->Summarize(ThreeGroups());
  summarizer->Summarize(DescriptorMatrix::Random(9, 4));
  EXPECT_EQ(summarizer->Summarize(ThreeGroups()).centers, first.centers);
}

bool IsRowOf(const Eigen::RowVectorXf& row, const DescriptorMatrix& matrix) {
  return ((matrix.rowwise() - row).rowwise().squaredNorm().array() == 0.0f).any();
}

double MeanDistanceToModes(const DescriptorMatrix& descriptors, const AppearanceModes& modes) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < descriptors.rows(); ++i) {
    sum += (descriptors.row(i) - modes.centers.row(modes.mode_of_descriptor[i])).norm();
  }
  return sum / static_cast<double>(descriptors.rows());
}

TEST(AppearanceSummarizer, EveryKindGivesTheFixedCount) {
  for (const auto kind :
       {AppearanceKind::kKMeans, AppearanceKind::kKMedoids, AppearanceKind::kRandom}) {
    const auto summarizer = MakeAppearanceSummarizer({.kind = kind, .count = 3, .min_count = 5});
    EXPECT_EQ(summarizer->NumModes(2), 2);
    EXPECT_EQ(summarizer->NumModes(100), 3);
    EXPECT_EQ(summarizer->Summarize(ThreeGroups()).centers.rows(), 3);
    EXPECT_EQ(summarizer->Summarize(ThreeGroups()).mode_of_descriptor.size(), 15u);
    EXPECT_EQ(summarizer->Summarize(ThreeGroups()).centers,
              summarizer->Summarize(ThreeGroups()).centers);
  }
}

TEST(AppearanceSummarizer, EveryKindMakesOneModeOfEqualDescriptors) {
  for (const auto kind :
       {AppearanceKind::kKMeans, AppearanceKind::kKMedoids, AppearanceKind::kRandom}) {
    const auto summarizer = MakeAppearanceSummarizer({.kind = kind, .count = 3});
    const AppearanceModes modes = summarizer->Summarize(DescriptorMatrix::Constant(8, 4, 0.5f));
    EXPECT_EQ(modes.centers.rows(), 1);
    EXPECT_EQ(modes.mode_of_descriptor, std::vector<int>(8, 0));
  }
}

TEST(KMedoidsSummarizer, FindsAMemberOfEachGroup) {
  const DescriptorMatrix descriptors = ThreeGroups();
  const AppearanceModes modes = MakeKMedoidsSummarizer({.count = 3})->Summarize(descriptors);
  ASSERT_EQ(modes.centers.rows(), 3);
  for (Eigen::Index mode = 0; mode < 3; ++mode) {
    EXPECT_TRUE(IsRowOf(modes.centers.row(mode), descriptors));
  }
  EXPECT_LT(MeanDistanceToModes(descriptors, modes), 0.05);
}

TEST(KMedoidsSummarizer, OneModeIsTheMostCentralMember) {
  DescriptorMatrix descriptors(5, 1);
  descriptors << 0.0f, 1.0f, 2.0f, 3.0f, 100.0f;
  const AppearanceModes modes = MakeKMedoidsSummarizer({.count = 1})->Summarize(descriptors);
  ASSERT_EQ(modes.centers.rows(), 1);
  EXPECT_EQ(modes.centers(0, 0), 2.0f);  // The mean is 21.2.
}

TEST(RandomSummarizer, PicksDifferentMembersForDifferentLandmarks) {
  const auto summarizer = MakeRandomSummarizer({.count = 1});
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<float> uniform;
  std::set<Eigen::Index> picked;
  for (int landmark = 0; landmark < 40; ++landmark) {
    DescriptorMatrix descriptors(6, 3);
    for (float& value : descriptors.reshaped()) {
      value = uniform(rng);
    }
    const AppearanceModes modes = summarizer->Summarize(descriptors);
    ASSERT_TRUE(IsRowOf(modes.centers.row(0), descriptors));
    Eigen::Index row;
    (descriptors.rowwise() - modes.centers.row(0)).rowwise().squaredNorm().minCoeff(&row);
    picked.insert(row);
  }
  EXPECT_EQ(picked.size(), 6u);
}

TEST(AppearanceSummarizer, ClustersDescribeBetterThanChance) {
  std::mt19937_64 rng(9);
  std::normal_distribution<float> normal;
  double sums[3] = {};
  for (int landmark = 0; landmark < 50; ++landmark) {
    DescriptorMatrix descriptors(24, 8);
    for (float& value : descriptors.reshaped()) {
      value = normal(rng);
    }
    for (const auto kind :
         {AppearanceKind::kKMeans, AppearanceKind::kKMedoids, AppearanceKind::kRandom}) {
      sums[static_cast<int>(kind)] += MeanDistanceToModes(
          descriptors,
          MakeAppearanceSummarizer({.kind = kind, .count = 6})->Summarize(descriptors));
    }
  }
  EXPECT_LT(sums[static_cast<int>(AppearanceKind::kKMeans)],
            sums[static_cast<int>(AppearanceKind::kKMedoids)]);
  EXPECT_LT(sums[static_cast<int>(AppearanceKind::kKMedoids)],
            0.95 * sums[static_cast<int>(AppearanceKind::kRandom)]);
}

TEST(AppearanceOptions, RefusesNonsense) {
  EXPECT_THROW(MakeRandomSummarizer({.count = -1}), Error);
  EXPECT_THROW(MakeKMeansSummarizer({.ratio = 1.5}), Error);
  EXPECT_THROW(MakeKMeansSummarizer({.min_count = 0}), Error);
  EXPECT_THROW(MakeKMeansSummarizer({.min_count = 3, .max_count = 2}), Error);
}

// Six landmarks seen 6, 5, ... 1 times; keyframe 0 sees the first four, keyframe 1 the last four.
VisibilityGraph SixLandmarks() {
  return {.num_observations = {7, 6, 5, 4, 3, 2},
          .landmarks_of_keyframe = {{0, 1, 2, 3}, {2, 3, 4, 5}}};
}

TEST(ObservationCountSelector, KeepsAllWithinTheBudget) {
  const auto selector = MakeObservationCountSelector({.max_descriptors = 6});
  EXPECT_EQ(selector->Select(SixLandmarks(), std::vector<int>(6, 1)),
            (std::vector<uint32_t>{0, 1, 2, 3, 4, 5}));
}

TEST(ObservationCountSelector, GivesEveryKeyframeItsShare) {
  const auto selector = MakeObservationCountSelector({.max_descriptors = 4});
  EXPECT_EQ(selector->Select(SixLandmarks(), std::vector<int>(6, 1)),
            (std::vector<uint32_t>{0, 1, 2, 3}));
  // By observations alone the second keyframe would get nothing.
  VisibilityGraph apart = SixLandmarks();
  apart.landmarks_of_keyframe = {{0, 1, 2, 3}, {4, 5}};
  EXPECT_EQ(selector->Select(apart, std::vector<int>(6, 1)), (std::vector<uint32_t>{0, 1, 4, 5}));
}

TEST(ObservationCountSelector, SpendsWhatSharesLeaveOver) {
  VisibilityGraph graph = SixLandmarks();
  graph.landmarks_of_keyframe = {{0, 1, 2, 3, 4}, {5}};
  const auto selector = MakeObservationCountSelector({.max_descriptors = 4});
  // Two and one by share, one more for the most observed of the rest.
  EXPECT_EQ(selector->Select(graph, std::vector<int>(6, 1)), (std::vector<uint32_t>{0, 1, 2, 5}));
}

TEST(ObservationCountSelector, NeverExceedsTheBudgetInDescriptors) {
  const std::vector<int> num_descriptors = {3, 3, 2, 2, 1, 1};
  for (int64_t budget = 1; budget <= 12; ++budget) {
    const auto selector = MakeObservationCountSelector({.max_descriptors = budget});
    int64_t spent = 0;
    for (const uint32_t i : selector->Select(SixLandmarks(), num_descriptors)) {
      spent += num_descriptors[i];
    }
    EXPECT_LE(spent, budget);
    EXPECT_GT(spent, budget == 12 ? 11 : 0);
  }
}

TEST(ObservationCountSelector, LeavesOutWhatIsSeenTooRarely) {
  const auto selector = MakeObservationCountSelector({.min_observations = 4});
  EXPECT_EQ(selector->Select(SixLandmarks(), std::vector<int>(6, 1)),
            (std::vector<uint32_t>{0, 1, 2, 3}));
}

TEST(LandmarkSelectionOptions, RefusesNonsense) {
  EXPECT_THROW(MakeObservationCountSelector({.max_descriptors = 0}), Error);
  EXPECT_THROW(MakeObservationCountSelector({.min_observations = 1}), Error);
  EXPECT_THROW(MakeCoverageSelector({.max_landmarks = -1}), Error);
  EXPECT_THROW(MakeCoverageSelector({.min_landmarks_per_keyframe = -1}), Error);
  EXPECT_THROW(MakeCoverageSelector({.missing_landmark_cost = -1.0}), Error);
  EXPECT_THROW(MakeCoverageSelector({.max_iterations = 0}), Error);
}

}  // namespace
}  // namespace cairn
