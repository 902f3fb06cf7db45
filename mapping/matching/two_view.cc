#include "mapping/matching/two_view.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "core/parallel_for.h"
#include "core/random.h"
#include "core/require.h"
#include "mapping/matching/pair_pose.h"

namespace cairn {
namespace {

// A guessed focal length is tried multiplied by these. With 0.85 times the long side, they cover
// lenses from 15 to 97 mm (as for 35 mm film), each within a quarter: strangers zoom, and crop.
constexpr double kGuessFactors[] = {1.0, 0.63, 1.6, 2.5};
std::vector<double> FactorsOf(const MappingCamera& camera) {
  return camera.source == FocalSource::kGuess
             ? std::vector<double>(std::begin(kGuessFactors), std::end(kGuessFactors))
             : std::vector<double>{1.0};
}

}  // namespace

void TwoViewOptions::Validate() const {
  RequireWithin("two_view.descriptors.max_ratio", descriptors.max_ratio, 0.1, 1.0);
  RequireWithin("two_view.descriptors.max_distance", descriptors.max_distance, 0.1, 2.0);
  RequireWithin("two_view.min_inliers", min_inliers, 8, 10'000);
  RequireWithin("two_view.max_iterations", max_iterations, 30, 1'000'000);
  RequireWithin("two_view.num_threads", num_threads, 1, 1024);
}

std::optional<TwoView> FindTwoView(const PhotoSet& set, int a, int b,
                                   const TwoViewOptions& options) {
  const MappingPhoto &photo_a = set.photos[a], &photo_b = set.photos[b];
  const auto descriptors_a = photo_a.descriptors.Load();
  const auto descriptors_b = photo_b.descriptors.Load();
  std::vector<FeatureMatch> matches =
      MatchDescriptors({*descriptors_a, photo_a.keypoints}, {*descriptors_b, photo_b.keypoints},
                       options.descriptors);
  std::stable_sort(
      matches.begin(), matches.end(),
      [](const FeatureMatch& p, const FeatureMatch& q) { return p.distance < q.distance; });
  if (static_cast<int>(matches.size()) < options.min_inliers) {
    return std::nullopt;
  }
  const MappingCamera& camera_a = set.cameras[photo_a.camera_idx];
  const MappingCamera& camera_b = set.cameras[photo_b.camera_idx];
  const bool same_camera = photo_a.camera_idx == photo_b.camera_idx;
  const uint64_t seed =
      HashWord(options.seed ^ HashWord(static_cast<uint64_t>(a) << 32 | static_cast<uint64_t>(b)));

  std::optional<TwoView> best;
  double best_score = 0.0;
  for (const double factor_a : FactorsOf(camera_a)) {
    for (const double factor_b : same_camera ? std::vector{factor_a} : FactorsOf(camera_b)) {
      const PairRays rays =
          MakePairRays(SourceOf(set, a, factor_a), SourceOf(set, b, factor_b), matches);
      const auto found = FindPairPose(rays.rays, options, best_score, seed);
      if (found && found->score > best_score) {
        best_score = found->score;
        best = MakeTwoView(rays, *found, matches);
        best->focal_factor_a = factor_a;
        best->focal_factor_b = factor_b;
      }
    }
  }
  if (best) {
    best->a = a;
    best->b = b;
  }
  return best;
}

std::vector<TwoView> FindTwoViews(const PhotoSet& set, std::span<const std::pair<int, int>> pairs,
                                  const TwoViewOptions& options, const StepProgress& progress) {
  options.Validate();
  std::vector<std::optional<TwoView>> found(pairs.size());
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(static_cast<int>(pairs.size()), options.num_threads, [&](int i) {
    found[i] = FindTwoView(set, pairs[i].first, pairs[i].second, options);
    if (progress) {
      const std::lock_guard lock(mutex);
      progress(++num_done, static_cast<int>(pairs.size()));
    }
  });
  std::vector<TwoView> views;
  for (std::optional<TwoView>& view : found) {
    if (view) {
      views.push_back(std::move(*view));
    }
  }
  return views;
}

}  // namespace cairn
