// Compares random grids with the inverted multi-index over the time of a query.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "lab/experiments/measure/index_variants.h"
#include "lab/experiments/measure/match_recall.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

std::string MethodName(IndexMethod method, bool with_orientation) {
  return std::string(IndexLabel(method)) + (with_orientation ? " + orientation" : "");
}

Variant MakeVariant(IndexMethod method, ExperimentSize size, int effort, bool with_orientation) {
  Variant variant{MethodName(method, with_orientation), static_cast<double>(effort), BestVariant()};
  variant.options.matching.index = IndexWithEffort(method, size, effort);
  variant.options.matching.position_weight = 0.0;
  if (!with_orientation) {
    variant.options.matching.orientation_weight = 0.0;
  }
  return variant;
}

std::vector<Variant> IndexVariants(const ExperimentContext& context) {
  std::vector<Variant> variants;
  for (const IndexMethod method : {IndexMethod::kRandomGrids, IndexMethod::kInvertedMultiIndex}) {
    for (const bool with_orientation : {true, false}) {
      for (const int effort : Efforts(method, context.size)) {
        variants.push_back(MakeVariant(method, context.size, effort, with_orientation));
      }
    }
  }
  for (const IndexMethod method : {IndexMethod::kInvertedLists, IndexMethod::kKdTree}) {
    for (const int effort : Efforts(method, context.size)) {
      variants.push_back(MakeVariant(method, context.size, effort, true));
    }
  }
  variants.push_back(MakeVariant(IndexMethod::kExhaustive, context.size, 1, true));
  return variants;
}

// Draws a measure over the time of matching, relative to the engine's default.
Figure TimeFigure(const std::string& name, const std::string& y_label,
                  const std::vector<MeasuredMatching>& matching,
                  const std::vector<Interval>& values, double reference_seconds) {
  Figure figure{name, "Indices over the time of matching", "CPU time of matching / default",
                y_label};
  figure.log_x = true;
  for (size_t i = 0; i < matching.size(); ++i) {
    const std::string& method = matching[i].variant.method;
    if (figure.series.empty() || figure.series.back().label != method) {
      figure.series.push_back({method, {}});
    }
    figure.series.back().points.push_back(
        {matching[i].MeanCpuSeconds() / reference_seconds, values[i]});
  }
  return figure;
}

ResultTable IndexTable(const std::vector<MeasuredMatching>& matching,
                       const std::vector<MeasuredVariant>& answers, double reference_seconds) {
  std::vector<Column> columns = {{"method"}, {"effort"}};
  AddIntervalColumns("match_recall", &columns);
  AddIntervalColumns("match_precision", &columns);
  AddIntervalColumns("average_precision", &columns);
  columns.push_back({"distances_a_query"});
  columns.push_back({"matching_cpu_ratio", true});
  columns.push_back({"matching_cpu_ms", true});
  ResultTable table(std::move(columns));
  for (size_t i = 0; i < matching.size(); ++i) {
    std::vector<Cell> row = {matching[i].variant.method, matching[i].variant.x};
    AddIntervalCells(matching[i].recall, &row);
    AddIntervalCells(matching[i].precision, &row);
    AddIntervalCells(answers[i].report.average_precision, &row);
    row.emplace_back(matching[i].MeanDistances());
    row.emplace_back(matching[i].MeanCpuSeconds() / reference_seconds);
    row.emplace_back(1e3 * matching[i].MeanCpuSeconds());
    table.AddRow(std::move(row));
  }
  return table;
}

ExperimentOutcome RunGridsVsMultiIndex(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const std::vector<Variant> variants = IndexVariants(context);
  const auto matching = MeasureMatching(*world, variants, context);
  const auto answers = MeasureVariants(*world, variants, context);
  const std::string grids = MethodName(IndexMethod::kRandomGrids, true);
  const std::string multi_index = MethodName(IndexMethod::kInvertedMultiIndex, true);
  const MeasuredMatching& best_grids = BestRecallOf(matching, grids);
  const MeasuredMatching& best_multi_index = BestRecallOf(matching, multi_index);
  const double reference_seconds = best_grids.MeanCpuSeconds();
  const Interval recall = RecallDifference(best_grids, best_multi_index);
  const Interval precision = ApDifference(BestOf(answers, grids), BestOf(answers, multi_index));

  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.table = IndexTable(matching, answers, reference_seconds);
  std::vector<Interval> recalls, precisions;
  for (size_t i = 0; i < matching.size(); ++i) {
    recalls.push_back(matching[i].recall);
    precisions.push_back(answers[i].report.average_precision);
  }
  outcome.figures = {TimeFigure("07_match_recall", "recall of right matches", matching, recalls,
                                reference_seconds),
                     TimeFigure("07_average_precision", "average precision", matching, precisions,
                                reference_seconds)};
  outcome.verdict = JudgeGreater(precision);
  outcome.sentence = fmt::format(
      "Both indices at their best, random grids differ from the inverted multi-index by {} in "
      "average precision and by {} in recall of right matches ({:.3f} against {:.3f}). They take "
      "{:.2f} of its matching time.",
      DifferenceText(precision), DifferenceText(recall), best_grids.recall.value,
      best_multi_index.recall.value,
      best_grids.MeanCpuSeconds() / best_multi_index.MeanCpuSeconds());
  return outcome;
}

}  // namespace

Experiment GridsVsMultiIndexExperiment() {
  return {"07_grids_vs_multi_index",
          "Random grids against the inverted multi-index",
          "Figure 8",
          "Given enough time, random grids reach a higher quality than the inverted multi-index.",
          "holds if random grids (with orientation) reach a higher average precision than the "
          "inverted multi-index, by a paired interval; does not hold if they reach a lower one.",
          "12 min",
          RunGridsVsMultiIndex};
}

}  // namespace cairn
