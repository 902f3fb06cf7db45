#include "mapping/matching/calibrate_guesses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/focal_length.h"
#include "core/parallel_for.h"
#include "mapping/matching/focal_grid.h"

namespace cairn {
namespace {

// Pairs of one camera that are looked at.
constexpr int kMaxPairsOfCamera = 60;
bool IsGuess(const MappingCamera& camera) { return camera.source == FocalSource::kGuess; }

const MappingCamera& CameraOf(const PhotoSet& set, int photo) {
  return set.cameras[set.photos[photo].camera_idx];
}

// Chooses the steps of all cameras.
class JointChoice {
 public:
  JointChoice(const std::vector<MappingCamera>& cameras, std::vector<PairVerdict> verdicts)
      : verdicts_(std::move(verdicts)), verdicts_of_camera_(cameras.size()) {
    for (size_t i = 0; i < verdicts_.size(); ++i) {
      const PairVerdict& verdict = verdicts_[i];
      if (verdict.is_free_a) {
        verdicts_of_camera_[verdict.camera_a].push_back(static_cast<int>(i));
      }
      if (verdict.is_free_b && verdict.camera_b != verdict.camera_a) {
        verdicts_of_camera_[verdict.camera_b].push_back(static_cast<int>(i));
      }
    }
  }

  bool IsJudged(int camera) const { return !verdicts_of_camera_[camera].empty(); }

  // Of the descents from equal steps of all cameras, the one that ends lowest.
  std::vector<int> Best() const {
    std::vector<int> best;
    double least = std::numeric_limits<double>::infinity();
    for (int start = 0; start < kNumFocalSteps; ++start) {
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
  FocalCosts CostsOf(int camera, const std::vector<int>& steps) const {
    FocalCosts costs;
    for (int step = 0; step < kNumFocalSteps; ++step) {
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
    const double sigmas = std::log(FocalFactorOf(step)) / FocalPrior::kMaxLogSigma;
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
        step = std::clamp(step + shift, 0, kNumFocalSteps - 1);
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

bool Calibrates(const PhotoSet& set, int a, int b) {
  return IsGuess(CameraOf(set, a)) || IsGuess(CameraOf(set, b));
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
  ParallelFor(static_cast<int>(used.size()), num_threads, [&](int i) {
    const TwoView& view = *used[i];
    verdicts[i] = JudgePair(set, set.cameras, view, IsGuess(CameraOf(set, view.a)),
                            IsGuess(CameraOf(set, view.b)));
  });
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
