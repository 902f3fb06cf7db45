// Compares voting with and without refinement over the number of candidates.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

struct NamedMode {
  const char* name;
  RefinementMode mode;
};
constexpr NamedMode kVotingAlone = {"voting alone", RefinementMode::kNever};
constexpr NamedMode kWhenWeak = {"refinement if weak", RefinementMode::kWhenWeak};
constexpr NamedMode kAlways = {"refinement always", RefinementMode::kAlways};

std::vector<Variant> RefinementVariants(const std::vector<int>& candidates) {
  std::vector<Variant> variants;
  for (const NamedMode& mode : {kVotingAlone, kWhenWeak, kAlways}) {
    for (const int count : candidates) {
      Variant variant{mode.name, static_cast<double>(count), BestVariant()};
      variant.options.refinement.mode = mode.mode;
      variant.options.voting.max_candidates = count;
      variants.push_back(variant);
    }
  }
  return variants;
}

ExperimentOutcome RunRefinement(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const auto candidates = context.Pick<std::vector<int>>({1, 8}, {1, 2, 4, 8, 16});
  const auto measured = MeasureVariants(*world, RefinementVariants(candidates), context);
  std::vector<Verdict> verdicts;
  std::string gains;
  for (const int count : {candidates.front(), VotingOptions().max_candidates, candidates.back()}) {
    const Interval gain =
        ApDifference(At(measured, kWhenWeak.name, count), At(measured, kVotingAlone.name, count));
    verdicts.push_back(JudgeGreater(gain));
    gains += fmt::format("{}{} with {}", gains.empty() ? "" : ", ", DifferenceText(gain), count);
  }
  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.table = AccuracyTable("candidates", measured,
                                At(measured, kWhenWeak.name, VotingOptions().max_candidates));
  outcome.figures = {AccuracyFigure("15_refinement", "Voting with and without refinement",
                                    "candidates P after voting", measured)};
  outcome.figures[0].log_x = true;
  outcome.verdict = JudgeAll(verdicts);
  outcome.sentence =
      "Refinement of weak queries changes average precision, by candidates after voting: " + gains +
      ".";
  return outcome;
}

}  // namespace

Experiment RefinementExperiment() {
  return {"15_refinement",
          "Voting with refinement over the number of candidates",
          "Figure 16",
          "A refinement stage after voting recovers queries with any number of candidates.",
          "holds if refinement improves average precision with the fewest, the default and the "
          "most candidates, each by a paired interval; does not hold if refinement reduces it with "
          "one of these numbers.",
          "1 min",
          RunRefinement};
}

}  // namespace cairn
