// Measures the time of the voting stage and its success over 50 scenes. A scene has 4,000 matches
// (1,000 keypoints with 4 each), of which 60 are right; a gravity error of 1 degree; keypoint noise
// of 1 px; landmark noise of 5 cm; a search disk of the given radius and a height band of 20 m. A
// candidate is right within 4 m and 6 degrees. `top8` and `top1` are the shares of scenes with a
// right candidate among the first 8, and in first place.
//
// AgainstDenseAccumulator compares the stage with the straightforward implementation in one run,
// over 200 x 200 x 8 m.
//
// RankOfTheTruth has 1.5 % right matches and, besides random ones, wrong matches that agree with
// one another. Of the scenes whose right matches alone give the pose, `top5_of_solvable` is the
// share with the true pose among the first 5 candidates; a share below 0.95 is an error. Poses
// resemble each other at random there; the experiments show how queries of a city rank.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>
#include <vector>

#include "core/angles.h"
#include "engine/pose/estimate_pose.h"
#include "engine/voting/pose_voting.h"
#include "support/pose_scene.h"
#include "support/voting_truth.h"

namespace cairn {
namespace {

using testing::HardScene;
using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;
using testing::RankOfTruth;

constexpr int kNumScenes = 50;

PoseSceneOptions SceneOptions(double radius_m, int num_inliers) {
  PoseSceneOptions options = HardScene(num_inliers);
  options.region_radius_m = radius_m;
  return options;
}

std::vector<PoseScene> MakeScenes(double radius_m, int num_inliers) {
  std::vector<PoseScene> scenes;
  PoseSceneOptions options = SceneOptions(radius_m, num_inliers);
  for (int seed = 1; seed <= kNumScenes; ++seed) {
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
    const auto [candidates, votes] = VoteForPoses(scene.query, scene.correspondences, options);
    const int rank = RankOfTruth(scene, candidates);
    num_top8 += rank >= 0;
    num_top1 += rank == 0;
    num_votes += votes;
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
  options.max_azimuth_difference_rad = kPi;
  Run(state, options);
}
BENCHMARK(VoteForPosesByGeometryAlone)
    ->ArgNames({"radius_m", "inliers"})
    ->Args({50, 60})
    ->Args({100, 60})
    ->Args({100, 30})
    ->Unit(benchmark::kMillisecond);

// A cell of 2 m and 5 degrees for every pose of the region, a vote for every match, cell of its ray
// and yaw; the best cell wins. Rays are clipped by the region alone. Returns the winner.
PoseCandidate DenseAccumulator(const PoseScene& scene) {
  constexpr double kCellM = 2.0;
  constexpr int kNumYaws = 72;
  const SearchRegion& region = scene.query.region;
  const int num_xy = static_cast<int>(std::ceil(2.0 * region.radius_m / kCellM));
  const int num_z = static_cast<int>(std::ceil((region.max_z_m - region.min_z_m) / kCellM));
  const Eigen::Vector3d corner(region.prior_xy_in_anchor.x() - region.radius_m,
                               region.prior_xy_in_anchor.y() - region.radius_m, region.min_z_m);
  std::vector<uint16_t> votes(static_cast<size_t>(num_xy) * num_xy * num_z * kNumYaws, 0);
  for (const Correspondence& match : scene.correspondences) {
    const Eigen::Vector3d ray =
        *scene.query.level_from_cam * scene.query.rays_in_cam[match.keypoint_idx];
    for (int yaw = 0; yaw < kNumYaws; ++yaw) {
      const double yaw_rad = 2.0 * kPi * yaw / kNumYaws;
      const Eigen::Vector3d step =
          kCellM * (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * ray);
      Eigen::Vector3d position = match.x_in_anchor - corner;
      for (int i = 0; i < static_cast<int>(2.0 * region.radius_m / kCellM); ++i) {
        position -= step;
        const Eigen::Vector3i cell = (position / kCellM).array().floor().cast<int>();
        if ((cell.array() >= 0).all() && cell.x() < num_xy && cell.y() < num_xy &&
            cell.z() < num_z) {
          ++votes[((static_cast<size_t>(yaw) * num_z + cell.z()) * num_xy + cell.y()) * num_xy +
                  cell.x()];
        }
      }
    }
  }
  const auto best = static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin());
  const Eigen::Vector3d best_cell(best % num_xy, best / num_xy % num_xy,
                                  best / num_xy / num_xy % num_z);
  PoseCandidate candidate;
  candidate.center_in_anchor = corner + kCellM * (best_cell + Eigen::Vector3d::Constant(0.5));
  candidate.yaw_rad = WrapAngleRad(2.0 * kPi * (best / num_xy / num_xy / num_z) / kNumYaws);
  return candidate;
}

// Wrong matches of a city do not lie anywhere: they agree with poses at places that look alike.
// Moves some to where a camera at one of `num_places` wrong poses would see them, but for
// `spread_m` along each axis.
struct Mirage {
  int num_places = 20;
  double share = 0.01;  // Of all matches, per place.
  double spread_m = 3.0;
};

void AddMirages(const Mirage& mirage, uint64_t seed, PoseScene* scene) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Rigid3d anchor_from_cam = scene->cam_from_anchor.Inverse();
  const double radius_m = scene->query.region.radius_m;
  std::vector<Rigid3d> anchor_from_place;
  for (int i = 0; i < mirage.num_places; ++i) {
    const Eigen::AngleAxisd turn(kPi * uniform(engine), Eigen::Vector3d::UnitZ());
    anchor_from_place.emplace_back(
        Eigen::Quaterniond(turn) * anchor_from_cam.rotation,
        Eigen::Vector3d(0.6 * radius_m * uniform(engine), 0.6 * radius_m * uniform(engine),
                        anchor_from_cam.translation.z()));
  }
  const auto num_moved = static_cast<size_t>(mirage.share * mirage.num_places *
                                             static_cast<double>(scene->correspondences.size()));
  std::uniform_int_distribution<size_t> any(0, scene->correspondences.size() - 1);
  for (size_t i = 0; i < num_moved; ++i) {
    const size_t match_idx = any(engine);
    if (scene->is_correct[match_idx]) {
      continue;
    }
    Correspondence& match = scene->correspondences[match_idx];
    const Rigid3d& place = anchor_from_place[i % anchor_from_place.size()];
    const double distance_m = 32.0 + 28.0 * uniform(engine);
    match.x_in_anchor =
        place * (scene->query.rays_in_cam[match.keypoint_idx] * distance_m) +
        mirage.spread_m * Eigen::Vector3d(uniform(engine), uniform(engine), uniform(engine));
    const Eigen::Vector3d to_camera = place.translation - match.x_in_anchor;
    match.azimuth_rad = static_cast<float>(std::atan2(to_camera.y(), to_camera.x()));
    match.size_m = static_cast<float>(scene->query.keypoints[match.keypoint_idx].scale_px /
                                      scene->query.camera.focal_px() * distance_m);
  }
}

// Solvable is a query whose right matches alone give the pose: any method that found them would.
bool IsSolvable(const PoseScene& scene) {
  std::vector<int> right;
  for (size_t i = 0; i < scene.is_correct.size(); ++i) {
    if (scene.is_correct[i]) {
      right.push_back(static_cast<int>(i));
    }
  }
  const auto estimate =
      EstimatePose(scene.query, scene.correspondences, right, PoseOptions(), /*seed=*/1);
  return estimate && testing::CenterErrorM(estimate->cam_from_anchor, scene.cam_from_anchor) < 1.0;
}

// 1.5 % of the 4 matches of each keypoint are right; 1 % of them agree with each of the places.
void RankOfTheTruth(benchmark::State& state) {
  constexpr double kInlierShare = 0.015, kMinTop5 = 0.95;
  const auto num_keypoints = static_cast<int>(state.range(1));
  const Mirage mirage = {.num_places = static_cast<int>(state.range(2))};
  int num_solvable = 0, num_top1 = 0, num_top5 = 0;
  for (auto _ : state) {
    for (int seed = 1; seed <= kNumScenes; ++seed) {
      PoseSceneOptions options = SceneOptions(static_cast<double>(state.range(0)),
                                              static_cast<int>(4 * kInlierShare * num_keypoints));
      options.num_keypoints = num_keypoints;
      options.seed = seed;
      PoseScene scene = MakePoseScene(options);
      AddMirages(mirage, seed, &scene);
      if (!IsSolvable(scene)) {
        continue;
      }
      const int rank = RankOfTruth(
          scene, VoteForPoses(scene.query, scene.correspondences, VotingOptions()).candidates);
      ++num_solvable;
      num_top1 += rank == 0;
      num_top5 += rank >= 0 && rank < 5;
    }
  }
  const double all = std::max(1, num_solvable);
  state.counters["solvable"] = all / static_cast<double>(kNumScenes * state.iterations());
  state.counters["top1_of_solvable"] = num_top1 / all;
  state.counters["top5_of_solvable"] = num_top5 / all;
  if (num_top5 < kMinTop5 * all) {
    state.SkipWithError("the truth is not among the first 5 often enough");
  }
}
BENCHMARK(RankOfTheTruth)
    ->ArgNames({"radius_m", "keypoints", "places"})
    ->Args({50, 1000, 0})
    ->Args({50, 1000, 20})
    ->Args({100, 1000, 20})
    ->Args({150, 1000, 20})
    ->Args({50, 500, 20})
    ->Args({50, 250, 20})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

double CpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void AgainstDenseAccumulator(benchmark::State& state) {
  constexpr double kRadiusM = 100.0, kHeightM = 8.0;
  std::vector<PoseScene> scenes = MakeScenes(kRadiusM, 60);
  double own_seconds = 0.0, dense_seconds = 0.0;
  int64_t num_runs = 0, num_own = 0, num_dense = 0;
  for (auto _ : state) {
    PoseScene& scene = scenes[num_runs % kNumScenes];
    scene.query.region.min_z_m = 0.0;
    scene.query.region.max_z_m = kHeightM;
    const double start = CpuSeconds();
    const auto own = VoteForPoses(scene.query, scene.correspondences, VotingOptions());
    const double middle = CpuSeconds();
    const PoseCandidate dense = DenseAccumulator(scene);
    own_seconds += middle - start;
    dense_seconds += CpuSeconds() - middle;
    num_own += RankOfTruth(scene, own.candidates) == 0;
    num_dense += RankOfTruth(scene, {dense}) == 0;
    ++num_runs;
  }
  state.counters["own_ms"] = 1e3 * own_seconds / static_cast<double>(num_runs);
  state.counters["dense_to_own"] = dense_seconds / own_seconds;
  state.counters["own_top1"] = static_cast<double>(num_own) / static_cast<double>(num_runs);
  state.counters["dense_top1"] = static_cast<double>(num_dense) / static_cast<double>(num_runs);
  if (num_own < 0.9 * static_cast<double>(num_runs)) {
    state.SkipWithError("voting collapsed");
  }
}
BENCHMARK(AgainstDenseAccumulator)->Iterations(kNumScenes)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cairn
