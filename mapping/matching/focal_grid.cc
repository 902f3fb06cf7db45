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

// The fits of a pair on the grid. One camera that both photos have is the rows, with one column.
class GridOfFits {
 public:
  GridOfFits(const PairFitter& fitter, bool is_free_a, bool is_free_b, bool is_one_camera)
      : fitter_(fitter),
        num_a_(is_free_a ? kNumFocalSteps : 1),
        num_b_(is_free_b && !is_one_camera ? kNumFocalSteps : 1),
        is_one_camera_(is_one_camera) {
    for (auto& row : costs_) {
      row.fill(std::numeric_limits<double>::infinity());
    }
  }

  struct Cell {
    int a = 0, b = 0;
    double cost = std::numeric_limits<double>::infinity();
    Rigid3d b_from_a;
  };

  const Cell& best() const { return best_; }
  double CostAt(int a, int b) const { return costs_[a][b]; }
  int num_a() const { return num_a_; }
  int num_b() const { return num_b_; }

  // Walks over the grid from a cell, so that each fit begins with the pose of a neighbor. Fits that
  // are better than those of earlier walks count.
  void WalkFrom(int a, int b, const Rigid3d& start) {
    b = std::min(b, num_b_ - 1);
    WalkOutward(std::min(a, num_a_ - 1), num_a_, start, [&](int row, const Rigid3d& from) {
      return WalkOutward(b, num_b_, from,
                         [&](int column, const Rigid3d& near) { return FitAt(row, column, near); });
    });
  }

 private:
  // Calls fit(step, pose of the step before) from `first` up, and from there down. Returns the pose
  // at `first`.
  template <typename Fit>
  static Rigid3d WalkOutward(int first, int num_steps, const Rigid3d& start, const Fit& fit) {
    const Rigid3d pose_at_first = fit(first, start);
    Rigid3d pose = pose_at_first;
    for (int step = first + 1; step < num_steps; ++step) {
      pose = fit(step, pose);
    }
    pose = pose_at_first;
    for (int step = first - 1; step >= 0; --step) {
      pose = fit(step, pose);
    }
    return pose_at_first;
  }

  Rigid3d FitAt(int a, int b, const Rigid3d& start) {
    const double factor_a = num_a_ > 1 ? FocalFactorOf(a) : 1.0;
    const double factor_b = is_one_camera_ ? factor_a : num_b_ > 1 ? FocalFactorOf(b) : 1.0;
    const PairFitter::Fit fit = fitter_.Refine(factor_a, factor_b, start);
    costs_[a][b] = std::min(costs_[a][b], fit.cost);
    if (fit.cost < best_.cost) {
      best_ = {a, b, fit.cost, fit.b_from_a};
    }
    return fit.b_from_a;
  }

  const PairFitter& fitter_;
  const int num_a_, num_b_;
  const bool is_one_camera_;
  std::array<std::array<double, kNumFocalSteps>, kNumFocalSteps> costs_;
  Cell best_;
};

}  // namespace

double FocalFactorOf(int step) { return std::exp(kLogStep * (step - kOwnFocalStep)); }

// A pose that was found under focal lengths far from the best ones leads fits astray, which then
// fit only where they happen to come back. So the grid is walked again from the best cell.
PairVerdict JudgePair(const PhotoSet& set, std::span<const MappingCamera> cameras,
                      const TwoView& view, bool is_free_a, bool is_free_b) {
  constexpr int kMaxWalks = 3;
  PairVerdict verdict;
  verdict.camera_a = set.photos[view.a].camera_idx;
  verdict.camera_b = set.photos[view.b].camera_idx;
  verdict.is_free_a = is_free_a;
  verdict.is_free_b = is_free_b;
  const PairFitter fitter(set, cameras, view);
  GridOfFits grid(fitter, is_free_a, is_free_b, verdict.camera_a == verdict.camera_b);
  grid.WalkFrom(StepOf(view.focal_factor_a), StepOf(view.focal_factor_b), view.b_from_a);
  for (int walk = 1; walk < kMaxWalks; ++walk) {
    const GridOfFits::Cell from = grid.best();
    grid.WalkFrom(from.a, from.b, from.b_from_a);
    if (grid.best().a == from.a && grid.best().b == from.b) {
      break;
    }
  }
  const double least = grid.best().cost;
  // Errors that are larger than stated, everywhere, make the pair less sure.
  const double noise =
      std::max(1.0, least / (kExpectedCost * static_cast<double>(fitter.NumMatches())));
  for (int a = 0; a < grid.num_a(); ++a) {
    for (int b = 0; b < grid.num_b(); ++b) {
      const double excess = kPairWeight * (grid.CostAt(a, b) - least) / noise;
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
