#include "ingest/tiles/landmark_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/check.h"

namespace cairn {
namespace {

constexpr int kPatience = 6;        // Rounds without a better bound before steps are halved.
constexpr double kFirstStep = 1.0;  // Of Polyak's.
constexpr double kLeastStep = 1e-4;
constexpr int kMaxSwapPasses = 8;
constexpr int kTryEvery = 5;  // Rounds.

// The program in the form that all steps use. Sparse: keyframes of landmarks, and back.
struct Program {
  std::vector<uint32_t> candidates;  // Landmarks that may be chosen.
  std::vector<double> scores;        // Parallel to candidates, as all below but `needs`.
  std::vector<int64_t> costs;
  std::vector<uint32_t> keyframe_begin;  // Offsets into `keyframes`, and one more.
  std::vector<uint32_t> keyframes;
  std::vector<int> needs;  // Per keyframe: landmarks that it wants.
  int64_t budget = 0;
  double missing_cost = 0.0;

  size_t size() const { return candidates.size(); }
  template <typename Visit>
  void ForEachKeyframe(uint32_t candidate, const Visit& visit) const {
    for (uint32_t j = keyframe_begin[candidate]; j < keyframe_begin[candidate + 1]; ++j) {
      visit(keyframes[j]);
    }
  }
};

Program MakeProgram(const VisibilityGraph& graph, const std::vector<int>& num_descriptors,
                    const LandmarkSelectionOptions& options) {
  Program program;
  program.missing_cost = options.missing_landmark_cost;
  const bool counts_landmarks = options.max_landmarks > 0;
  program.budget = counts_landmarks ? options.max_landmarks : options.max_descriptors;
  constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> candidate_of(graph.num_landmarks(), kNone);
  for (uint32_t i = 0; i < graph.num_landmarks(); ++i) {
    if (graph.num_observations[i] >= options.min_observations) {
      candidate_of[i] = static_cast<uint32_t>(program.size());
      program.candidates.push_back(i);
      program.scores.push_back(graph.num_observations[i]);
      program.costs.push_back(counts_landmarks ? 1 : num_descriptors[i]);
    }
  }
  std::vector<std::vector<uint32_t>> keyframes_of(program.size());
  for (uint32_t k = 0; k < graph.landmarks_of_keyframe.size(); ++k) {
    int num_seen = 0;
    for (const uint32_t landmark : graph.landmarks_of_keyframe[k]) {
      if (candidate_of[landmark] != kNone) {
        keyframes_of[candidate_of[landmark]].push_back(k);
        ++num_seen;
      }
    }
    program.needs.push_back(std::min(num_seen, options.min_landmarks_per_keyframe));
  }
  for (const std::vector<uint32_t>& keyframes : keyframes_of) {
    program.keyframe_begin.push_back(static_cast<uint32_t>(program.keyframes.size()));
    program.keyframes.insert(program.keyframes.end(), keyframes.begin(), keyframes.end());
  }
  program.keyframe_begin.push_back(static_cast<uint32_t>(program.keyframes.size()));
  return program;
}

// A set of candidates, and how often it covers each keyframe.
class Choice {
 public:
  explicit Choice(const Program& program)
      : program_(&program), chosen_(program.size(), false), covered_(program.needs.size(), 0) {}

  bool Has(uint32_t candidate) const { return chosen_[candidate]; }
  int64_t spent() const { return spent_; }
  int covered(size_t keyframe) const { return covered_[keyframe]; }

  void Add(uint32_t candidate) { Change(candidate, 1); }
  void Remove(uint32_t candidate) { Change(candidate, -1); }

  // What the objective gains by adding a candidate that is not in, or loses by removing one that
  // is.
  double Worth(uint32_t candidate) const {
    const int spare = chosen_[candidate] ? 1 : 0;
    int num_needed = 0;
    program_->ForEachKeyframe(candidate, [&](uint32_t k) {
      num_needed += covered_[k] - spare < program_->needs[k] ? 1 : 0;
    });
    return program_->scores[candidate] + program_->missing_cost * num_needed;
  }

  int64_t NumMissing() const {
    int64_t missing = 0;
    for (size_t k = 0; k < covered_.size(); ++k) {
      missing += std::max(0, program_->needs[k] - covered_[k]);
    }
    return missing;
  }
  double Objective() const {
    double score = 0.0;
    for (size_t i = 0; i < chosen_.size(); ++i) {
      score += chosen_[i] ? program_->scores[i] : 0.0;
    }
    return score - program_->missing_cost * static_cast<double>(NumMissing());
  }

 private:
  void Change(uint32_t candidate, int sign) {
    chosen_[candidate] = sign > 0;
    spent_ += sign * program_->costs[candidate];
    program_->ForEachKeyframe(candidate, [&](uint32_t k) { covered_[k] += sign; });
  }

  const Program* program_;
  std::vector<bool> chosen_;
  std::vector<int> covered_;
  int64_t spent_ = 0;
};

struct Ranked {
  double density;  // Profit by cost.
  uint32_t candidate;

  // By density, then by index, so that ties are the same everywhere.
  bool operator<(const Ranked& other) const {
    return std::pair(-density, candidate) < std::pair(-other.density, other.candidate);
  }
};

// The relaxed program for given prices: all that is worth its cost, best first, until the budget is
// spent; the last may be taken in part.
struct Relaxed {
  double value = 0.0;  // Of the knapsack with a part of the last.
  Choice whole;        // Without the part.
};

// Reorders `ranked` so that the longest affordable run of the best stands in front, in linear time;
// returns its length and takes its cost from `budget`.
size_t PartitionAffordable(const Program& program, std::vector<Ranked>* ranked, int64_t* budget) {
  size_t begin = 0, end = ranked->size();
  while (begin < end) {
    const size_t middle = begin + (end - begin + 1) / 2;
    const auto at = [&](size_t i) { return ranked->begin() + static_cast<std::ptrdiff_t>(i); };
    if (middle < end) {
      std::nth_element(at(begin), at(middle), at(end));
    }
    int64_t cost = 0;
    for (size_t i = begin; i < middle; ++i) {
      cost += program.costs[(*ranked)[i].candidate];
    }
    if (cost <= *budget) {
      *budget -= cost;
      begin = middle;
    } else if (middle == begin + 1) {
      end = begin;
    } else {
      end = middle;
    }
  }
  return begin;
}

Relaxed SolveRelaxed(const Program& program, const std::vector<double>& prices) {
  std::vector<Ranked> ranked;
  ranked.reserve(program.size());
  for (uint32_t i = 0; i < program.size(); ++i) {
    double profit = program.scores[i];
    program.ForEachKeyframe(i, [&](uint32_t k) { profit += prices[k]; });
    ranked.push_back({profit / static_cast<double>(program.costs[i]), i});
  }
  int64_t budget = program.budget;
  const size_t num_whole = PartitionAffordable(program, &ranked, &budget);
  Relaxed relaxed{.value = 0.0, .whole = Choice(program)};
  for (size_t i = 0; i < num_whole; ++i) {
    const uint32_t candidate = ranked[i].candidate;
    relaxed.value += ranked[i].density * static_cast<double>(program.costs[candidate]);
    relaxed.whole.Add(candidate);
  }
  if (num_whole < ranked.size()) {
    relaxed.value +=
        std::min_element(ranked.begin() + static_cast<std::ptrdiff_t>(num_whole), ranked.end())
            ->density *
        static_cast<double>(budget);
  }
  for (size_t k = 0; k < prices.size(); ++k) {
    relaxed.value -= prices[k] * program.needs[k];
  }
  return relaxed;
}

// Candidates that are in (or not in) by worth: the best to add first, the worst to keep first.
std::vector<Ranked> RankByWorth(const Program& program, const Choice& choice, bool is_in) {
  std::vector<Ranked> ranked;
  for (uint32_t i = 0; i < program.size(); ++i) {
    if (choice.Has(i) == is_in) {
      const double density = choice.Worth(i) / static_cast<double>(program.costs[i]);
      ranked.push_back({is_in ? -density : density, i});
    }
  }
  std::sort(ranked.begin(), ranked.end());
  return ranked;
}

void Fill(const Program& program, Choice* choice) {
  for (const Ranked& ranked : RankByWorth(program, *choice, false)) {
    if (choice->spent() + program.costs[ranked.candidate] <= program.budget) {
      choice->Add(ranked.candidate);
    }
  }
}

// Trades what is worth least for what is worth more. Returns whether anything was traded.
bool Swap(const Program& program, Choice* choice) {
  const std::vector<Ranked> outside = RankByWorth(program, *choice, false);
  const std::vector<Ranked> inside = RankByWorth(program, *choice, true);
  bool has_changed = false;
  auto in = outside.begin();
  auto out = inside.begin();
  // Where the lists cross, worths only fall further apart.
  while (in != outside.end() && out != inside.end() && in->density > -out->density) {
    const double loss = choice->Worth(out->candidate);
    choice->Remove(out->candidate);
    const double gain = choice->Worth(in->candidate);
    if (gain > loss && choice->spent() + program.costs[in->candidate] <= program.budget) {
      choice->Add(in->candidate);
      has_changed = true;
      ++in;
      ++out;
      continue;
    }
    choice->Add(out->candidate);
    // Trades since the ranking may have made one dearer or the other cheaper.
    const bool is_dearer =
        loss > -out->density * static_cast<double>(program.costs[out->candidate]);
    is_dearer ? ++out : ++in;
  }
  return has_changed;
}

void Improve(const Program& program, Choice* choice) {
  Fill(program, choice);
  for (int pass = 0; pass < kMaxSwapPasses && Swap(program, choice); ++pass) {
    Fill(program, choice);
  }
}

// Subgradient ascent on the prices of the keyframes' constraints.
class Relaxation {
 public:
  Relaxation(const Program& program, const LandmarkSelectionOptions& options)
      : program_(program), options_(options), prices_(program.needs.size(), 0.0), best_(program) {}

  CoverageSolution Solve() {
    Try(Choice(program_));
    for (int i = 0; i < options_.max_iterations && step_ > kLeastStep && !IsClosed(); ++i) {
      Relaxed relaxed = SolveRelaxed(program_, prices_);
      rounds_without_better_ = relaxed.value < bound_ ? 0 : rounds_without_better_ + 1;
      bound_ = std::min(bound_, relaxed.value);
      if (rounds_without_better_ >= kPatience) {
        step_ *= 0.5;
        rounds_without_better_ = 0;
      }
      MovePrices(relaxed);
      const double objective = relaxed.whole.Objective();
      if (objective > best_whole_ || i % kTryEvery == kTryEvery - 1) {
        best_whole_ = std::max(best_whole_, objective);
        Try(std::move(relaxed.whole));
      }
    }
    return Finish();
  }

 private:
  bool IsClosed() const {
    constexpr double kMaxGap = 1e-4;  // Enough; relative to the bound.
    return std::isfinite(bound_) &&
           bound_ - objective_ <= kMaxGap * std::max(1.0, std::abs(bound_));
  }

  void Try(Choice choice) {
    Improve(program_, &choice);
    const double objective = choice.Objective();
    if (objective > objective_) {
      objective_ = objective;
      best_ = std::move(choice);
    }
  }

  void MovePrices(const Relaxed& relaxed) {
    double sq_norm = 0.0;
    std::vector<double> gradient(prices_.size());
    for (size_t k = 0; k < prices_.size(); ++k) {
      gradient[k] = program_.needs[k] - relaxed.whole.covered(k);
      // Prices that cannot move further do not count.
      const bool is_stuck = (prices_[k] <= 0.0 && gradient[k] < 0.0) ||
                            (prices_[k] >= program_.missing_cost && gradient[k] > 0.0);
      sq_norm += is_stuck ? 0.0 : gradient[k] * gradient[k];
    }
    if (sq_norm == 0.0) {
      step_ = 0.0;  // The prices are optimal.
      return;
    }
    const double length = step_ * std::max(1e-9, relaxed.value - objective_) / sq_norm;
    for (size_t k = 0; k < prices_.size(); ++k) {
      prices_[k] = std::clamp(prices_[k] + length * gradient[k], 0.0, program_.missing_cost);
    }
  }

  CoverageSolution Finish() const {
    CoverageSolution solution;
    for (uint32_t i = 0; i < program_.size(); ++i) {
      if (best_.Has(i)) {
        solution.selection.push_back(program_.candidates[i]);
      }
    }
    solution.objective = objective_;
    solution.upper_bound = std::max(objective_, bound_);
    solution.num_missing = best_.NumMissing();
    return solution;
  }

  const Program& program_;
  const LandmarkSelectionOptions& options_;
  std::vector<double> prices_;  // Per keyframe, in [0, missing_cost].
  Choice best_;
  double objective_ = -std::numeric_limits<double>::infinity();
  double best_whole_ = -std::numeric_limits<double>::infinity();
  double bound_ = std::numeric_limits<double>::infinity();
  double step_ = kFirstStep;
  int rounds_without_better_ = 0;
};

}  // namespace

CoverageSolution SolveCoverage(const VisibilityGraph& graph,
                               const std::vector<int>& num_descriptors,
                               const LandmarkSelectionOptions& options) {
  options.Validate();
  CAIRN_CHECK(num_descriptors.size() == graph.num_landmarks(),
              "there must be one count for each landmark");
  const Program program = MakeProgram(graph, num_descriptors, options);
  return Relaxation(program, options).Solve();
}

}  // namespace cairn
