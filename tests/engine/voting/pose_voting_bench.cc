// 4,000 matches (1,000 keypoints with 4 each), 60 of them right, gravity off by 1 degree, keypoint
// noise of 1 px, landmark noise of 5 cm, over a disc of the given radius and a height band of 20 m:
// time of the voting stage and share of 50 scenes whose truth is among the 8 candidates (`top8`) or
// is the first (`top1`). A candidate is right within 4 m and 6 degrees.
#include <benchmark/benchmark.h>

#include <numbers>
#include <vector>

#include "engine/voting/pose_voting.h"
#include "support/pose_scene.h"
#include "support/voting_truth.h"

namespace cairn {
namespace {

using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;
using testing::RankOfTruth;

constexpr int kNumScenes = 50;

std::vector<PoseScene> MakeScenes(double radius_m, int num_inliers) {
  std::vector<PoseScene> scenes;
  for (int seed = 1; seed <= kNumScenes; ++seed) {
    PoseSceneOptions options;
    options.num_keypoints = 1000;
    options.matches_per_keypoint = 4;
    options.num_inliers = num_inliers;
    options.pixel_noise_px = 1.0;
    options.gravity_noise_rad = 0.0175;
    options.landmark_noise_m = 0.05;
    options.region_radius_m = radius_m;
    options.seed = seed;
    scenes.push_back(MakePoseScene(options));
  }
  return scenes;
}

void Run(benchmark::State& state, const VotingOptions& options) {
  const auto scenes =
      MakeScenes(static_cast<double>(state.range(0)), static_cast<int>(state.range(1)));
  int64_t num_runs = 0, num_top8 = 0, num_top1 = 0, num_votes = 0, num_supporters = 0;
  for (auto _ : state) {
    const PoseScene& scene = scenes[num_runs % kNumScenes];
    StageCounters counters;
    const auto candidates = VoteForPoses(scene.query, scene.correspondences, options, &counters);
    const int rank = RankOfTruth(scene, candidates);
    num_top8 += rank >= 0;
    num_top1 += rank == 0;
    num_votes += counters.num_votes;
    num_supporters += candidates.empty() ? 0 : candidates[0].correspondences.size();
    ++num_runs;
  }
  const auto mean = [&](int64_t sum) {
    return static_cast<double>(sum) / static_cast<double>(num_runs);
  };
  state.counters["top8"] = mean(num_top8);
  state.counters["top1"] = mean(num_top1);
  state.counters["votes"] = mean(num_votes);
  state.counters["supporters"] = mean(num_supporters);
}

void VoteForPosesWithAllPriors(benchmark::State& state) { Run(state, VotingOptions()); }
BENCHMARK(VoteForPosesWithAllPriors)
    ->ArgNames({"radius_m", "inliers"})
    ->Args({50, 60})
    ->Args({100, 60})
    ->Args({100, 30})
    ->Args({100, 20})
    ->Args({150, 60})
    ->Unit(benchmark::kMillisecond);

// Neither the keypoint's size nor the azimuth of the view clip a ray.
void VoteForPosesByGeometryAlone(benchmark::State& state) {
  VotingOptions options;
  options.max_distance_factor = 0.0;
  options.max_azimuth_difference_rad = std::numbers::pi;
  Run(state, options);
}
BENCHMARK(VoteForPosesByGeometryAlone)
    ->ArgNames({"radius_m", "inliers"})
    ->Args({50, 60})
    ->Args({100, 60})
    ->Args({100, 30})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cairn
