// Measures the orientation and position terms of the matching distance in both indices.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "lab/experiments/measure/index_variants.h"
#include "lab/experiments/measure/match_recall.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

struct PriorTerms {
  const char* name;
  bool orientation;
  bool position;
};
constexpr PriorTerms kTerms[] = {{"none", false, false},
                                 {"orientation", true, false},
                                 {"position", false, true},
                                 {"both", true, true}};
constexpr int kNone = 0, kBoth = 3;  // Indices into kTerms; x of the variants.

std::vector<Variant> PriorVariants(ExperimentSize size) {
  std::vector<Variant> variants;
  for (const IndexMethod method : {IndexMethod::kRandomGrids, IndexMethod::kInvertedMultiIndex}) {
    for (size_t i = 0; i < std::size(kTerms); ++i) {
      Variant variant{IndexLabel(method), static_cast<double>(i), BestVariant()};
      MatchingOptions& matching = variant.options.matching;
      matching.index = IndexOfMethod(method, size);
      matching.orientation_weight = kTerms[i].orientation ? matching.orientation_weight : 0.0;
      matching.position_weight = kTerms[i].position ? matching.position_weight : 0.0;
      variants.push_back(variant);
    }
  }
  return variants;
}

ResultTable PriorTable(const std::vector<MeasuredMatching>& matching,
                       const std::vector<MeasuredVariant>& answers) {
  std::vector<Column> columns = {{"method"}, {"terms"}};
  AddIntervalColumns("match_recall", &columns);
  AddIntervalColumns("match_precision", &columns);
  AddIntervalColumns("average_precision", &columns);
  columns.push_back({"matching_cpu_ratio", true});
  ResultTable table(std::move(columns));
  for (size_t i = 0; i < matching.size(); ++i) {
    std::vector<Cell> row = {matching[i].variant.method,
                             kTerms[static_cast<size_t>(matching[i].variant.x)].name};
    AddIntervalCells(matching[i].recall, &row);
    AddIntervalCells(matching[i].precision, &row);
    AddIntervalCells(answers[i].report.average_precision, &row);
    row.emplace_back(matching[i].MeanCpuSeconds() / matching.front().MeanCpuSeconds());
    table.AddRow(std::move(row));
  }
  return table;
}

ExperimentOutcome RunPriors(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const std::vector<Variant> variants = PriorVariants(context.size);
  const auto matching = MeasureMatching(*world, variants, context);
  const auto answers = MeasureVariants(*world, variants, context);
  const std::string grids = IndexLabel(IndexMethod::kRandomGrids);
  const std::string multi_index = IndexLabel(IndexMethod::kInvertedMultiIndex);
  const Interval grids_gain = ApDifference(At(answers, grids, kBoth), At(answers, grids, kNone));
  const Interval multi_index_gain =
      ApDifference(At(answers, multi_index, kBoth), At(answers, multi_index, kNone));
  const size_t offset = std::size(kTerms);
  const Interval recall_gain = RecallDifference(matching[kBoth], matching[kNone]);
  const Interval multi_index_recall_gain =
      RecallDifference(matching[offset + kBoth], matching[offset + kNone]);

  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.parameters.emplace_back("orientation weight",
                                  fmt::format("{}", MatchingOptions().orientation_weight));
  outcome.parameters.emplace_back("position weight",
                                  fmt::format("{}", MatchingOptions().position_weight));
  outcome.table = PriorTable(matching, answers);
  Figure figure = AccuracyFigure("08_priors", "Terms of the matching distance", "terms", answers);
  for (const PriorTerms& terms : kTerms) {
    figure.x_names.emplace_back(terms.name);
  }
  outcome.figures = {figure};
  outcome.verdict = JudgeAll({JudgeGreater(grids_gain), JudgeGreater(multi_index_gain)});
  outcome.sentence = fmt::format(
      "Both terms together change average precision by {} with random grids and by {} with the "
      "inverted multi-index. They change recall of right matches by {} and {}.",
      DifferenceText(grids_gain), DifferenceText(multi_index_gain), DifferenceText(recall_gain),
      DifferenceText(multi_index_recall_gain));
  return outcome;
}

}  // namespace

Experiment PriorsExperiment() {
  return {"08_priors",
          "Orientation and position prior in matching",
          "Figure 9",
          "Keypoint orientation and position prior improve both indices if they are terms of the "
          "distance.",
          "holds if both terms together improve the average precision of random grids and of the "
          "inverted multi-index, each by a paired interval; does not hold if one index gets worse.",
          "3 min",
          RunPriors};
}

}  // namespace cairn
