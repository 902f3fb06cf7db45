// Tests queries with a deadline: in time, too late, and next to those without one.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "core/focal_length.h"
#include "engine/mapped_streets.h"

namespace cairn {
namespace {

using testing::ExpectPose;
using testing::ExpectSameAnswer;
using testing::QueryAt;
using testing::QueryPose;

class LocalizerDeadline : public testing::OneStreetTest {};

TEST_F(LocalizerDeadline, SaysTimeoutWhenTheDeadlineHasPassed) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const LocalizeResult result = localizer().Localize(query);
  EXPECT_EQ(result.reason, NotLocalizedReason::kTimeout);
  EXPECT_EQ(result.map_version,
            localizer().Localize(QueryAt(*world_, QueryPose(20.0))).map_version);
  EXPECT_EQ(result.counters.num_keypoints, query.num_features());
}

// Wherever in the query the deadline falls.
TEST_F(LocalizerDeadline, AnswersByTheDeadlineOrSaysTimeout) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  const LocalizeResult unhurried = localizer().Localize(query);
  ASSERT_TRUE(unhurried.localized);
  for (int percent = 0; percent <= 120; percent += 5) {
    query.deadline = std::chrono::steady_clock::now() +
                     std::chrono::microseconds(
                         static_cast<int64_t>(1e4 * percent * unhurried.times.total_seconds));
    const LocalizeResult result = localizer().Localize(query);
    if (result.localized) {
      ExpectPose(result, *world_, QueryPose(20.0), 0.1, 0.005);
    } else {
      EXPECT_EQ(result.reason, NotLocalizedReason::kTimeout) << percent;
    }
  }
}

// The answer of an earlier round keeps the camera of that round.
TEST_F(LocalizerDeadline, AnswersWithAnUncertainCameraByTheDeadlineOrSaysTimeout) {
  LocalizerOptions options;
  options.refinement.min_trusted_evidence = 1e6;  // Every round seeks the camera.
  const Localizer doubtful = map_->WithOptions(options);
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.camera = WithFocalScaled(query.camera, 1.3);
  query.focal = FocalPrior{.log_sigma = 0.25};
  doubtful.Localize(query);  // Loads the tiles.
  const LocalizeResult unhurried = doubtful.Localize(query);
  ExpectPose(unhurried, *world_, QueryPose(20.0), 0.1, 0.005);
  for (int percent = 0; percent <= 120; percent += 10) {
    query.deadline = std::chrono::steady_clock::now() +
                     std::chrono::microseconds(
                         static_cast<int64_t>(1e4 * percent * unhurried.times.total_seconds));
    const LocalizeResult result = doubtful.Localize(query);
    if (result.localized) {
      ExpectPose(result, *world_, QueryPose(20.0), 0.5, 0.02);
    } else {
      EXPECT_EQ(result.reason, NotLocalizedReason::kTimeout) << percent;
    }
  }
}

TEST_F(LocalizerDeadline, AColdQueryInAHurryAnswersFromAPartOfTheIndex) {
  const LocalizeQuery unhurried = QueryAt(*world_, QueryPose(20.0));
  LocalizerOptions options;
  options.matching.index.grids.num_grids = 2;  // Two parts.
  const LocalizeResult expected = map_->WithOptions(options).Localize(unhurried);
  options.tiles.deadline_share = 0.0;  // No time for more than the first part of the index.
  const Localizer cold = map_->WithOptions(options);
  LocalizeQuery hurried = unhurried;
  hurried.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
  const LocalizeResult result = cold.Localize(hurried);
  ExpectPose(result, *world_, QueryPose(20.0), 0.1, 0.005);
  EXPECT_TRUE(result.counters.tiles_cut_short);
  EXPECT_FALSE(result.counters.matching_cut_short);
  EXPECT_LT(result.counters.num_distances, expected.counters.num_distances);
  // Whether or not the rest has been built by now.
  const LocalizeResult again = cold.Localize(unhurried);
  ExpectSameAnswer(again, expected);
  EXPECT_FALSE(again.counters.tiles_cut_short);
  EXPECT_FALSE(again.counters.matching_cut_short);
  EXPECT_FALSE(again.counters.pose_cut_short);
}

TEST_F(LocalizerDeadline, QueriesWithTimeAreNotAffectedByThoseInAHurry) {
  const LocalizeQuery unhurried = QueryAt(*world_, QueryPose(20.0));
  LocalizeQuery hurried = unhurried;
  hurried.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
  const LocalizeResult expected = localizer().Localize(unhurried);
  LocalizerOptions options;
  options.num_threads = 2;
  options.tiles.deadline_share = 0.0;
  const Localizer cold = map_->WithOptions(options);
  std::vector<LocalizeResult> results(4);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < results.size(); ++i) {
    threads.emplace_back([&, i] { results[i] = cold.Localize(i % 2 == 0 ? hurried : unhurried); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (size_t i = 0; i < results.size(); ++i) {
    ExpectPose(results[i], *world_, QueryPose(20.0), 0.1, 0.005);
    if (i % 2 == 1) {
      ExpectSameAnswer(results[i], expected);
    }
  }
}

TEST_F(LocalizerDeadline, SaysTimeoutWhenMatchingHasNoTime) {
  LocalizerOptions options;
  options.matching.deadline_share = 0.0;
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
  const LocalizeResult result = map_->WithOptions(options).Localize(query);
  EXPECT_EQ(result.reason, NotLocalizedReason::kTimeout);
  EXPECT_TRUE(result.counters.matching_cut_short);
  EXPECT_FALSE(result.counters.tiles_cut_short);
}

}  // namespace
}  // namespace cairn
