#include "fusion/rival/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "fusion/rival/run_estimators.h"
#include "fusion/rival/simulated_recording.h"

namespace cairn::fusion {
namespace {

using ::testing::HasSubstr;

Recording ShortRecording() {
  testing::SimulationOptions options;
  options.duration_s = 12.0;
  options.num_features = 150;
  options.map_sigma_m = 0.05;
  return testing::MakeRecording(testing::Simulation(options), {});
}

TEST(Comparison, AllEstimatorsFindTheMapAndStayNearTheTruth) {
  const Recording recording = ShortRecording();
  const std::vector<MethodResult> results = CompareEstimators(recording, {});
  ASSERT_EQ(results.size(), 1 + PaperVariants().size());
  EXPECT_EQ(results.front().name, "EKF");
  for (const MethodResult& result : results) {
    EXPECT_EQ(result.num_counted_frames, recording.frames.size() - recording.first_counted_frame)
        << result.name;
    EXPECT_LT(result.position_rmse_m, 0.1) << result.name;
    EXPECT_LT(result.rotation_rmse_rad, 0.01) << result.name;
    EXPECT_GT(result.mean_matches, 50.0) << result.name;
    EXPECT_GT(result.frame_seconds.mean, 0.0) << result.name;
    EXPECT_LE(result.position_change_m.rms, result.position_change_m.maximum) << result.name;
  }
}

// The point of the paper's figure: what a rival forgets with its cameras comes back as jumps.
TEST(Comparison, TheFilterIsSmootherThanAWindowThatForgets) {
  ComparisonOptions options;
  options.variants = {{10, 10, DiscardPolicy::kDiscard}};
  const std::vector<MethodResult> results = CompareEstimators(ShortRecording(), options);
  EXPECT_LT(results[0].position_change_m.rms, results[1].position_change_m.rms);
  EXPECT_LT(results[0].rotation_change_rad.rms, 0.7 * results[1].rotation_change_rad.rms);
}

TEST(Comparison, MarginalizationMakesTheRivalSmoother) {
  ComparisonOptions options;
  options.variants = {{10, 5, DiscardPolicy::kDiscard}, {10, 5, DiscardPolicy::kMarginalize}};
  const std::vector<MethodResult> results = CompareEstimators(ShortRecording(), options);
  EXPECT_LT(results[2].rotation_change_rad.rms, 0.8 * results[1].rotation_change_rad.rms);
}

TEST(Comparison, RunsRepeatUpToRounding) {
  const Recording recording = ShortRecording();
  const BundleAdjusterOptions options =
      RivalOptions(recording, {5, 5, DiscardPolicy::kMarginalize});
  const std::vector<FrameRun> a = RunBundleAdjuster(recording, options, false);
  const std::vector<FrameRun> b = RunBundleAdjuster(recording, options, false);
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].global_from_imu.has_value(), b[i].global_from_imu.has_value());
    if (a[i].global_from_imu) {
      EXPECT_LT((a[i].global_from_imu->translation - b[i].global_from_imu->translation).norm(),
                1e-4);
    }
  }
}

TEST(Comparison, TableHasARowAMethodAndTheRatios) {
  MethodResult filter;
  filter.name = "EKF";
  filter.update_seconds.mean = 0.5e-3;
  filter.position_rmse_m = 0.02;
  MethodResult rival;
  rival.name = RivalVariant{5, 2, DiscardPolicy::kMarginalize}.Name();
  rival.update_seconds.mean = 10e-3;
  rival.position_rmse_m = 0.04;
  const std::string table = ComparisonTable("title", std::vector<MethodResult>{filter, rival});
  EXPECT_THAT(table, HasSubstr("title"));
  EXPECT_THAT(table, HasSubstr("BA-5-2-M"));
  EXPECT_THAT(table, HasSubstr("20.0"));
  EXPECT_THAT(table, HasSubstr("0.50"));
}

TEST(Comparison, RefusesRecordingsItCannotRun) {
  Recording recording = ShortRecording();
  recording.imu.resize(recording.imu.size() / 2);
  EXPECT_THROW(CompareEstimators(recording, {}), Error);
  recording.frames.resize(recording.first_counted_frame);
  EXPECT_THROW(CompareEstimators(recording, {}), Error);
}

}  // namespace
}  // namespace cairn::fusion
