#include "mapping/matching/focal_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/focal_length.h"
#include "mapping/matching/pair_rays.h"
#include "mapping/matching/relative_pose.h"

namespace cairn {
namespace {

// Logarithms of the focal lengths that are tried, relative to the guess: from 12 to 118 mm (as for
// 35 mm film), each within 8 %. The adjustment finds the rest.
constexpr double kLogStep = 0.15;
// Inliers of a pair that are looked at: more do not make its verdict surer than its lens
// distortion allows.
constexpr size_t kMaxInliers = 150;
// Half the robust squared error (RefineRelativePose) that a right match has on average.
constexpr double kExpectedCost = 0.35;
// Distortion and the principal point are unknown, too, and their errors are the same in all matches
// of a photo, so a pair counts for less than its matches.
constexpr double kPairWeight = 0.25;
// A pair raises the cost by little more than this, logarithmically: two views may be wrong.
constexpr double kMaxPairCost = 6.0;
// A focal length is known if half and twice as much cost this much more. Of normal errors, 1 in
// 1,000 costs more.
constexpr double kMinRise = 5.0;
// The steps of the grid and unknown distortions leave such an error where the costs are sharp: of
// ten photos of a facade, six focal lengths were 5 to 10 % from those of the adjusted model.
constexpr double kMinLogSigma = 0.07;

int StepOf(double factor) {
  const int step = kOwnFocalStep + static_cast<int>(std::lround(std::log(factor) / kLogStep));
  return std::clamp(step, 0, kNumFocalSteps - 1);
}

// The inliers of a view evenly.
std::vector<FeatureMatch> SomeInliers(const TwoView& view) {
  std::vector<FeatureMatch> some;
  const size_t count = std::min(kMaxInliers, view.inliers.size());
  for (size_t i = 0; i < count; ++i) {
    some.push_back(view.inliers[i * view.inliers.size() / count]);
  }
  return some;
}

// Fits a pair under focal lengths, beginning with a pose that is near.
class PairFitter {
 public:
  PairFitter(const PhotoSet& set, std::span<const MappingCamera> cameras, const TwoView& view)
      : set_(set), cameras_(cameras), view_(view), matches_(SomeInliers(view)) {}

  struct Fit {
    Rigid3d b_from_a;
    double cost = std::numeric_limits<double>::infinity();
  };

  Fit Refine(double factor_a, double factor_b, const Rigid3d& start) const {
    const PairRays rays =
        MakePairRays(SourceOf(view_.a, factor_a), SourceOf(view_.b, factor_b), matches_);
    std::vector<int> all(rays.rays.size());
    for (size_t i = 0; i < all.size(); ++i) {
      all[i] = static_cast<int>(i);
    }
    const auto refined = RefineRelativePose(rays.rays, all, start);
    // What a camera cannot see counts as if it did not fit at all.
    constexpr double kLost = 5.0;
    const double num_lost = static_cast<double>(matches_.size() - rays.rays.size());
    return refined ? Fit{refined->b_from_a, refined->cost + kLost * num_lost} : Fit{start};
  }

  size_t NumMatches() const { return matches_.size(); }

 private:
  RaySource SourceOf(int photo, double factor) const {
    const MappingPhoto& source = set_.photos[photo];
    return {source, WithFocalScaled(cameras_[source.camera_idx].camera, factor)};
  }

  const PhotoSet& set_;
  const std::span<const MappingCamera> cameras_;
  const TwoView& view_;
  std::vector<FeatureMatch> matches_;
};

}  // namespace

double FocalFactorOf(int step) { return std::exp(kLogStep * (step - kOwnFocalStep)); }

// Walks over the grid from the focal lengths under which the view was found, so that each fit
// begins with the pose of a neighbor.
PairVerdict JudgePair(const PhotoSet& set, std::span<const MappingCamera> cameras,
                      const TwoView& view, bool is_free_a, bool is_free_b) {
  PairVerdict verdict;
  verdict.camera_a = set.photos[view.a].camera_idx;
  verdict.camera_b = set.photos[view.b].camera_idx;
  verdict.is_free_a = is_free_a;
  verdict.is_free_b = is_free_b;
  const bool is_one_camera = verdict.camera_a == verdict.camera_b;
  const PairFitter fitter(set, cameras, view);
  const int num_a = verdict.is_free_a ? kNumFocalSteps : 1;
  const int num_b = verdict.is_free_b && !is_one_camera ? kNumFocalSteps : 1;
  const int first_a = verdict.is_free_a ? StepOf(view.focal_factor_a) : 0;
  const int first_b = num_b > 1 ? StepOf(view.focal_factor_b) : 0;
  double least = std::numeric_limits<double>::infinity();
  const auto fit_at = [&](int a, int b, const Rigid3d& start) {
    const double factor_a = verdict.is_free_a ? FocalFactorOf(a) : 1.0;
    const double factor_b = is_one_camera ? factor_a : num_b > 1 ? FocalFactorOf(b) : 1.0;
    const PairFitter::Fit fit = fitter.Refine(factor_a, factor_b, start);
    verdict.costs[a][b] = static_cast<float>(fit.cost);
    least = std::min(least, fit.cost);
    return fit.b_from_a;
  };
  const auto fit_row = [&](int a, const Rigid3d& start) {
    const Rigid3d first = fit_at(a, first_b, start);
    Rigid3d pose = first;
    for (int b = first_b + 1; b < num_b; ++b) {
      pose = fit_at(a, b, pose);
    }
    pose = first;
    for (int b = first_b - 1; b >= 0; --b) {
      pose = fit_at(a, b, pose);
    }
    return first;
  };
  const Rigid3d first = fit_row(first_a, view.b_from_a);
  Rigid3d pose = first;
  for (int a = first_a + 1; a < num_a; ++a) {
    pose = fit_row(a, pose);
  }
  pose = first;
  for (int a = first_a - 1; a >= 0; --a) {
    pose = fit_row(a, pose);
  }
  // Errors that are larger than stated, everywhere, make the pair less sure.
  const double noise =
      std::max(1.0, least / (kExpectedCost * static_cast<double>(fitter.NumMatches())));
  for (int a = 0; a < num_a; ++a) {
    for (int b = 0; b < num_b; ++b) {
      const double excess = kPairWeight * (verdict.costs[a][b] - least) / noise;
      verdict.costs[a][b] = static_cast<float>(kMaxPairCost * std::log1p(excess / kMaxPairCost));
    }
  }
  return verdict;
}

// The vertex of the parabola through the least cost and its neighbors. Nothing if the costs do not
// tell the focal length.
std::optional<KnownFocal> VertexOf(const FocalCosts& costs) {
  const int best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  const auto rise_to = [&](int step) {
    return costs[std::clamp(step, 0, kNumFocalSteps - 1)] - costs[best];
  };
  const int octave = static_cast<int>(std::lround(std::log(2.0) / kLogStep));
  if (best == 0 || best == kNumFocalSteps - 1 || rise_to(best - octave) < kMinRise ||
      rise_to(best + octave) < kMinRise) {
    return std::nullopt;
  }
  const double slope = 0.5 * (costs[best + 1] - costs[best - 1]);
  const double curvature = costs[best + 1] + costs[best - 1] - 2.0 * costs[best];
  const double offset = curvature > 0.0 ? std::clamp(-slope / curvature, -0.5, 0.5) : 0.0;
  const double log_sigma =
      curvature > 0.0 ? kLogStep / std::sqrt(curvature) : FocalPrior::kUnknownLogSigma;
  return KnownFocal{FocalFactorOf(best) * std::exp(kLogStep * offset),
                    std::clamp(log_sigma, kMinLogSigma, FocalPrior::kUnknownLogSigma)};
}

}  // namespace cairn
