#include "mapping/matching/calibrate_guesses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/focal_length.h"
#include "core/parallel_for.h"
#include "mapping/matching/pair_rays.h"
#include "mapping/matching/relative_pose.h"

namespace cairn {
namespace {

// Logarithms of the focal lengths that are tried, relative to the guess: from 12 to 118 mm (as for
// 35 mm film), each within 8 %. The adjustment finds the rest.
constexpr double kLogStep = 0.15;
constexpr int kLowest = -6, kHighest = 9;
constexpr int kNumSteps = kHighest - kLowest + 1;
// Inliers of a pair that are looked at: more do not make its verdict surer than its lens
// distortion allows.
constexpr size_t kMaxInliers = 150;
// Pairs of one camera that are looked at.
constexpr int kMaxPairsOfCamera = 60;
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

double FactorOf(int step) { return std::exp(kLogStep * (kLowest + step)); }

int StepOf(double factor) {
  const int step = static_cast<int>(std::lround(std::log(factor) / kLogStep)) - kLowest;
  return std::clamp(step, 0, kNumSteps - 1);
}

// What a pair says: how much worse its inliers fit than under its best focal lengths.
struct PairVerdict {
  int camera_a = 0, camera_b = 0;
  bool is_guess_a = false, is_guess_b = false;
  // [step of a][step of b]; one step for a camera that is no guess, and the diagonal alone (as
  // [step][0]) if both photos have one camera.
  std::array<std::array<float, kNumSteps>, kNumSteps> costs;

  double CostAt(int step_a, int step_b) const {
    return costs[is_guess_a ? step_a : 0][is_guess_b && camera_a != camera_b ? step_b : 0];
  }
};

bool IsGuess(const MappingCamera& camera) { return camera.source == FocalSource::kGuess; }

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
  PairFitter(const PhotoSet& set, const TwoView& view)
      : set_(set), view_(view), matches_(SomeInliers(view)) {}

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
    return {source, WithFocalScaled(set_.cameras[source.camera_idx].camera, factor)};
  }

  const PhotoSet& set_;
  const TwoView& view_;
  std::vector<FeatureMatch> matches_;
};

// Walks over the grid from the focal lengths under which the view was found, so that each fit
// begins with the pose of a neighbor.
PairVerdict Judge(const PhotoSet& set, const TwoView& view) {
  PairVerdict verdict;
  verdict.camera_a = set.photos[view.a].camera_idx;
  verdict.camera_b = set.photos[view.b].camera_idx;
  verdict.is_guess_a = IsGuess(set.cameras[verdict.camera_a]);
  verdict.is_guess_b = IsGuess(set.cameras[verdict.camera_b]);
  const bool is_one_camera = verdict.camera_a == verdict.camera_b;
  const PairFitter fitter(set, view);
  const int num_a = verdict.is_guess_a ? kNumSteps : 1;
  const int num_b = verdict.is_guess_b && !is_one_camera ? kNumSteps : 1;
  const int first_a = verdict.is_guess_a ? StepOf(view.focal_factor_a) : 0;
  const int first_b = num_b > 1 ? StepOf(view.focal_factor_b) : 0;
  double least = std::numeric_limits<double>::infinity();
  const auto fit_at = [&](int a, int b, const Rigid3d& start) {
    const double factor_a = verdict.is_guess_a ? FactorOf(a) : 1.0;
    const double factor_b = is_one_camera ? factor_a : num_b > 1 ? FactorOf(b) : 1.0;
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

// Chooses the steps of all cameras.
class JointChoice {
 public:
  JointChoice(const std::vector<MappingCamera>& cameras, std::vector<PairVerdict> verdicts)
      : verdicts_(std::move(verdicts)), verdicts_of_camera_(cameras.size()) {
    for (size_t i = 0; i < verdicts_.size(); ++i) {
      const PairVerdict& verdict = verdicts_[i];
      if (verdict.is_guess_a) {
        verdicts_of_camera_[verdict.camera_a].push_back(static_cast<int>(i));
      }
      if (verdict.is_guess_b && verdict.camera_b != verdict.camera_a) {
        verdicts_of_camera_[verdict.camera_b].push_back(static_cast<int>(i));
      }
    }
  }

  bool IsJudged(int camera) const { return !verdicts_of_camera_[camera].empty(); }

  // Of the descents from equal steps of all cameras, the one that ends lowest.
  std::vector<int> Best() const {
    std::vector<int> best;
    double least = std::numeric_limits<double>::infinity();
    for (int start = 0; start < kNumSteps; ++start) {
      std::vector<int> steps(verdicts_of_camera_.size(), start);
      Descend(&steps);
      const double cost = Total(steps);
      if (cost < least) {
        least = cost;
        best = std::move(steps);
      }
    }
    while (DescendTogether(&best, &least)) {
    }
    return best;
  }

  // The costs of all steps of a camera while the others keep theirs.
  std::array<double, kNumSteps> CostsOf(int camera, const std::vector<int>& steps) const {
    std::array<double, kNumSteps> costs;
    for (int step = 0; step < kNumSteps; ++step) {
      costs[step] = PriorCost(step);
      for (const int i : verdicts_of_camera_[camera]) {
        const PairVerdict& verdict = verdicts_[i];
        costs[step] += verdict.CostAt(verdict.camera_a == camera ? step : steps[verdict.camera_a],
                                      verdict.camera_b == camera ? step : steps[verdict.camera_b]);
      }
    }
    return costs;
  }

 private:
  // Photos of strangers are zoomed and cropped: the prior is as wide as priors may be.
  static double PriorCost(int step) {
    const double sigmas = std::log(FactorOf(step)) / FocalPrior::kMaxLogSigma;
    return 0.5 * sigmas * sigmas;
  }

  void Descend(std::vector<int>* steps) const {
    constexpr int kMaxSweeps = 30;
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
      bool has_changed = false;
      for (size_t camera = 0; camera < steps->size(); ++camera) {
        if (!verdicts_of_camera_[camera].empty()) {
          const auto costs = CostsOf(static_cast<int>(camera), *steps);
          const int best =
              static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
          has_changed = has_changed || costs[best] < costs[(*steps)[camera]];
          (*steps)[camera] = best;
        }
      }
      if (!has_changed) {
        return;
      }
    }
  }

  // All cameras one step up or down, and the descent from there: pairs hold the ratios of focal
  // lengths much better than their common factor, so no camera moves alone. False if that does not
  // lower the cost.
  bool DescendTogether(std::vector<int>* steps, double* cost) const {
    for (const int shift : {-1, 1}) {
      std::vector<int> moved = *steps;
      for (int& step : moved) {
        step = std::clamp(step + shift, 0, kNumSteps - 1);
      }
      Descend(&moved);
      const double moved_cost = Total(moved);
      if (moved_cost < *cost) {
        *cost = moved_cost;
        *steps = std::move(moved);
        return true;
      }
    }
    return false;
  }

  double Total(const std::vector<int>& steps) const {
    double total = 0.0;
    for (const PairVerdict& verdict : verdicts_) {
      total += verdict.CostAt(steps[verdict.camera_a], steps[verdict.camera_b]);
    }
    for (size_t camera = 0; camera < steps.size(); ++camera) {
      total += verdicts_of_camera_[camera].empty() ? 0.0 : PriorCost(steps[camera]);
    }
    return total;
  }

  std::vector<PairVerdict> verdicts_;
  std::vector<std::vector<int>> verdicts_of_camera_;
};

struct KnownFocal {
  double factor = 1.0;
  double log_sigma = 0.0;
};

// The vertex of the parabola through the least cost and its neighbors. Nothing if the costs do not
// tell the focal length.
std::optional<KnownFocal> VertexOf(const std::array<double, kNumSteps>& costs) {
  const int best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  const auto rise_to = [&](int step) {
    return costs[std::clamp(step, 0, kNumSteps - 1)] - costs[best];
  };
  const int octave = static_cast<int>(std::lround(std::log(2.0) / kLogStep));
  if (best == 0 || best == kNumSteps - 1 || rise_to(best - octave) < kMinRise ||
      rise_to(best + octave) < kMinRise) {
    return std::nullopt;
  }
  const double slope = 0.5 * (costs[best + 1] - costs[best - 1]);
  const double curvature = costs[best + 1] + costs[best - 1] - 2.0 * costs[best];
  const double offset = curvature > 0.0 ? std::clamp(-slope / curvature, -0.5, 0.5) : 0.0;
  const double log_sigma =
      curvature > 0.0 ? kLogStep / std::sqrt(curvature) : FocalPrior::kUnknownLogSigma;
  return KnownFocal{FactorOf(best) * std::exp(kLogStep * offset),
                    std::clamp(log_sigma, kMinLogSigma, FocalPrior::kUnknownLogSigma)};
}

bool Calibrates(const PhotoSet& set, int a, int b) {
  return IsGuess(set.cameras[set.photos[a].camera_idx]) ||
         IsGuess(set.cameras[set.photos[b].camera_idx]);
}

}  // namespace

bool HasGuesses(const PhotoSet& set) {
  return std::any_of(set.cameras.begin(), set.cameras.end(), IsGuess);
}

std::vector<std::pair<int, int>> PairsForCalibration(const PhotoSet& set,
                                                     std::span<const std::pair<int, int>> pairs) {
  // Evenly over the set: the first photos of a walk may look at one wall.
  std::vector<int> num_of_camera(set.cameras.size(), 0);
  const auto cameras_of = [&](const std::pair<int, int>& pair) {
    return std::array{set.photos[pair.first].camera_idx, set.photos[pair.second].camera_idx};
  };
  for (const auto& pair : pairs) {
    for (const int camera : cameras_of(pair)) {
      ++num_of_camera[camera];
    }
  }
  std::vector<int> num_seen(set.cameras.size(), 0);
  std::vector<std::pair<int, int>> chosen;
  for (const auto& pair : pairs) {
    bool is_wanted = false;
    for (const int camera : cameras_of(pair)) {
      const int64_t seen = num_seen[camera]++;
      const int64_t wanted = std::min(num_of_camera[camera], kMaxPairsOfCamera);
      is_wanted = is_wanted ||
                  (IsGuess(set.cameras[camera]) && (seen + 1) * wanted / num_of_camera[camera] >
                                                       seen * wanted / num_of_camera[camera]);
    }
    if (is_wanted) {
      chosen.push_back(pair);
    }
  }
  return chosen;
}

std::vector<MappingCamera> CalibrateGuesses(const PhotoSet& set, std::span<const TwoView> views,
                                            int num_threads) {
  std::vector<const TwoView*> used;
  for (const TwoView& view : views) {
    if (view.kind == TwoViewKind::kGeneral && Calibrates(set, view.a, view.b)) {
      used.push_back(&view);
    }
  }
  std::vector<PairVerdict> verdicts(used.size());
  ParallelFor(static_cast<int>(used.size()), num_threads,
              [&](int i) { verdicts[i] = Judge(set, *used[i]); });
  const JointChoice choice(set.cameras, std::move(verdicts));
  const std::vector<int> steps = choice.Best();
  std::vector<MappingCamera> cameras = set.cameras;
  for (int i = 0; i < static_cast<int>(cameras.size()); ++i) {
    if (!choice.IsJudged(i)) {
      continue;
    }
    if (const auto known = VertexOf(choice.CostsOf(i, steps))) {
      cameras[i].camera = WithFocalScaled(cameras[i].camera, known->factor);
      cameras[i].focal.log_sigma = known->log_sigma;
      cameras[i].source = FocalSource::kPhotos;
    }
  }
  return cameras;
}

}  // namespace cairn
