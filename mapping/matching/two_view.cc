#include "mapping/matching/two_view.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/focal_length.h"
#include "core/parallel_for.h"
#include "core/random.h"
#include "core/require.h"
#include "core/statistics.h"
#include "engine/pose/ransac.h"
#include "mapping/matching/pair_rays.h"
#include "mapping/matching/relative_pose.h"

namespace cairn {
namespace {

// A rotation that explains this share of the inliers leaves no translation to be found.
constexpr double kMaxExplainedByRotation = 0.8;
// A guessed focal length is tried multiplied by these. With 0.85 times the long side, they cover
// lenses from 15 to 97 mm (as for 35 mm film), each within a quarter: strangers zoom, and crop.
constexpr double kGuessFactors[] = {1.0, 0.63, 1.6, 2.5};
// An error of the focal length of a quarter moves a ray, relative to its neighbors, by some pixels.
constexpr double kGuessSigmaFactor = 2.0;
// What remains is the distortion, and half of that error.
constexpr double kPhotosSigmaFactor = 1.5;

double MedianParallaxRad(std::span<const RayMatch> rays, std::span<const int> inliers,
                         const Eigen::Quaterniond& b_from_a) {
  std::vector<double> angles;
  for (const int i : inliers) {
    const Eigen::Vector3d turned = b_from_a * rays[i].a;
    angles.push_back(std::atan2(turned.cross(rays[i].b).norm(), turned.dot(rays[i].b)));
  }
  return Median(std::move(angles));
}

struct PairPose {
  RefinedRelativePose pose;
  std::vector<int> inliers;
  double score = 0.0;
};

// Nothing if no pose has more than `score_to_beat`.
std::optional<PairPose> FindPairPose(std::span<const RayMatch> rays, const TwoViewOptions& options,
                                     double score_to_beat, uint64_t seed) {
  if (static_cast<int>(rays.size()) < options.min_inliers) {
    return std::nullopt;
  }
  RelativePoseProblem problem(rays, seed);
  const auto result = LoRansac(&problem,
                               RansacOptions{.min_iterations = 30,
                                             .max_iterations = options.max_iterations,
                                             .min_score = score_to_beat},
                               seed);
  if (!result.model) {
    return std::nullopt;
  }
  PairPose found;
  found.score = result.score;
  found.inliers = problem.InliersOf(result.model->b_from_a);
  const auto refined = RefineRelativePose(rays, found.inliers, result.model->b_from_a);
  if (!refined) {
    return std::nullopt;
  }
  found.pose = *refined;
  found.inliers = problem.InliersOf(refined->b_from_a);
  if (static_cast<int>(found.inliers.size()) < options.min_inliers) {
    return std::nullopt;
  }
  return found;
}

TwoView MakeTwoView(const PairRays& rays, const PairPose& found,
                    const std::vector<FeatureMatch>& matches) {
  TwoView view;
  view.b_from_a = found.pose.b_from_a;
  view.rotation_sigma_rad = found.pose.rotation_sigma_rad;
  view.direction_sigma_rad = found.pose.direction_sigma_rad;
  const RotationFit rotation = FitRotation(rays.rays, found.inliers, view.b_from_a.rotation);
  if (rotation.num_explained >=
      kMaxExplainedByRotation * static_cast<double>(found.inliers.size())) {
    view.kind = TwoViewKind::kRotationOnly;
    view.b_from_a.rotation = rotation.b_from_a;
  }
  view.parallax_rad = MedianParallaxRad(rays.rays, found.inliers, view.b_from_a.rotation);
  for (const int i : found.inliers) {
    view.inliers.push_back(matches[rays.match_of_ray[i]]);
  }
  std::sort(view.inliers.begin(), view.inliers.end(),
            [](const FeatureMatch& p, const FeatureMatch& q) { return p.a_idx < q.a_idx; });
  return view;
}

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
  std::vector<FeatureMatch> matches =
      MatchDescriptors({photo_a.descriptors, photo_a.keypoints},
                       {photo_b.descriptors, photo_b.keypoints}, options.descriptors);
  std::stable_sort(
      matches.begin(), matches.end(),
      [](const FeatureMatch& p, const FeatureMatch& q) { return p.distance < q.distance; });
  if (static_cast<int>(matches.size()) < options.min_inliers) {
    return std::nullopt;
  }
  const MappingCamera& camera_a = set.cameras[photo_a.camera_idx];
  const MappingCamera& camera_b = set.cameras[photo_b.camera_idx];
  const bool same_camera = photo_a.camera_idx == photo_b.camera_idx;
  const auto sigma_factor = [](const MappingCamera& camera) {
    return camera.source == FocalSource::kGuess    ? kGuessSigmaFactor
           : camera.source == FocalSource::kPhotos ? kPhotosSigmaFactor
                                                   : 1.0;
  };
  const uint64_t seed =
      HashWord(options.seed ^ HashWord(static_cast<uint64_t>(a) << 32 | static_cast<uint64_t>(b)));

  std::optional<TwoView> best;
  double best_score = 0.0;
  for (const double factor_a : FactorsOf(camera_a)) {
    for (const double factor_b : same_camera ? std::vector{factor_a} : FactorsOf(camera_b)) {
      const RaySource source_a{photo_a, WithFocalScaled(camera_a.camera, factor_a),
                               sigma_factor(camera_a)};
      const RaySource source_b{photo_b, WithFocalScaled(camera_b.camera, factor_b),
                               sigma_factor(camera_b)};
      const PairRays rays = MakePairRays(source_a, source_b, matches);
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
