#include "mapping/matching/pair_pose.h"

#include <algorithm>
#include <utility>

#include "core/focal_length.h"
#include "core/rotation_between.h"
#include "core/statistics.h"
#include "engine/pose/ransac.h"
#include "mapping/matching/plane_pair.h"

namespace cairn {
namespace {

// A rotation that explains this share of the inliers leaves no translation to be found.
constexpr double kMaxExplainedByRotation = 0.8;
// An error of the focal length of a quarter moves a ray, relative to its neighbors, by some pixels.
constexpr double kGuessSigmaFactor = 2.0;
// What remains is the distortion, and half of that error.
constexpr double kPhotosSigmaFactor = 1.5;
// What remains is the distortion, which moves the corners, and an error of the focal length by some
// percent. Lund's street with 2,000 features has 26 of 29 photos in the map, and 17 with 1.
constexpr double kExifSigmaFactor = 1.25;
// A plane with a smaller share of the inliers does not draw RANSAC to its twin: the twin would lose
// the others.
constexpr double kLeastShareOfPlane = 0.5;

double SigmaFactorOf(FocalSource certainty) {
  switch (certainty) {
    case FocalSource::kGuess:
      return kGuessSigmaFactor;
    case FocalSource::kPhotos:
      return kPhotosSigmaFactor;
    case FocalSource::kExif:
    case FocalSource::kGrowth:
      return kExifSigmaFactor;
    case FocalSource::kCalibration:
      break;
  }
  return 1.0;
}

double MedianParallaxRad(std::span<const RayMatch> rays, std::span<const int> inliers,
                         const Eigen::Quaterniond& b_from_a) {
  std::vector<double> angles;
  for (const int i : inliers) {
    angles.push_back(AngleBetweenRad(b_from_a * rays[i].a, rays[i].b));
  }
  return Median(std::move(angles));
}

// The twin if it has more inliers. A pose that explains the pictures of a plane by its twin keeps
// only the points that are in front of the cameras there.
std::optional<PairPose> BetterTwin(std::span<const RayMatch> rays, const PairPose& found,
                                   int min_inliers, uint64_t seed) {
  const auto plane = FitPlane(rays, found.inliers, found.pose.b_from_a, seed);
  if (!plane ||
      plane->num_explained < kLeastShareOfPlane * static_cast<double>(found.inliers.size())) {
    return std::nullopt;
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int i : found.inliers) {
    sum += rays[i].a;
  }
  const auto twin = TwinOf(found.pose.b_from_a, *plane, sum);
  if (!twin) {
    return std::nullopt;
  }
  std::optional<PairPose> other = SettlePose(rays, twin->b_from_a, min_inliers);
  return other && other->inliers.size() > found.inliers.size() ? other : std::nullopt;
}

// A pose refined with the errors that its inliers show.
struct SharpPose {
  RefinedRelativePose pose;
  std::vector<RayMatch> rays;  // With these errors.
};

// Among the inliers, matches that are wrong by some pixels bend a pose, and a turn explains a short
// walk along a wall, if exact keypoints count as rough ones.
SharpPose Sharpen(std::span<const RayMatch> rays, const PairPose& found) {
  constexpr int kRounds = 2;
  SharpPose sharp{found.pose, {}};
  for (int round = 0; round < kRounds; ++round) {
    sharp.rays = WithNoise(rays, NoiseOf(rays, found.inliers, sharp.pose.b_from_a));
    const std::vector<int> inliers =
        RelativePoseProblem(sharp.rays, 0).InliersOf(sharp.pose.b_from_a);
    if (const auto refined = RefineRelativePose(sharp.rays, inliers, sharp.pose.b_from_a)) {
      sharp.pose = *refined;
    }
  }
  return sharp;
}

}  // namespace

RaySource SourceOf(const PhotoSet& set, int photo, double focal_factor) {
  const MappingPhoto& source = set.photos[photo];
  const MappingCamera& camera = set.cameras[source.camera_idx];
  return {source, WithFocalScaled(camera.camera, focal_factor), SigmaFactorOf(camera.Certainty())};
}

std::optional<PairPose> SettlePose(std::span<const RayMatch> rays, const Rigid3d& b_from_a,
                                   int min_inliers) {
  constexpr int kRounds = 3;
  RelativePoseProblem problem(rays, 0);
  PairPose settled;
  settled.pose.b_from_a = b_from_a;
  settled.inliers = problem.InliersOf(b_from_a);
  for (int round = 0; round < kRounds; ++round) {
    const auto refined = RefineRelativePose(rays, settled.inliers, settled.pose.b_from_a);
    if (!refined) {
      return std::nullopt;
    }
    settled.pose = *refined;
    std::vector<int> next = problem.InliersOf(refined->b_from_a);
    const bool is_done = next == settled.inliers;
    settled.inliers = std::move(next);
    if (is_done) {
      break;
    }
  }
  if (static_cast<int>(settled.inliers.size()) < min_inliers) {
    return std::nullopt;
  }
  settled.score = problem.ScoreMinimal({EssentialOf(settled.pose.b_from_a), {}}, -1.0);
  return settled;
}

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
  if (std::optional<PairPose> twin = BetterTwin(rays, found, options.min_inliers, seed)) {
    // Both explain the epipolar lines, by which focal lengths are compared, about equally well.
    twin->score = std::max(twin->score, found.score);
    return twin;
  }
  if (static_cast<int>(found.inliers.size()) < options.min_inliers) {
    return std::nullopt;
  }
  return found;
}

TwoView MakeTwoView(const PairRays& rays, const PairPose& found,
                    std::span<const FeatureMatch> matches) {
  TwoView view;
  const SharpPose sharp = Sharpen(rays.rays, found);
  view.b_from_a = sharp.pose.b_from_a;
  view.rotation_sigma_rad = sharp.pose.rotation_sigma_rad;
  view.direction_sigma_rad = sharp.pose.direction_sigma_rad;
  const RotationFit rotation = FitRotation(sharp.rays, found.inliers, view.b_from_a.rotation);
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

}  // namespace cairn
