#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "lab/experiments/experiment_result.h"
#include "lab/experiments/runs/experiment_list.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

ResultTable SmallTable() {
  std::vector<Column> columns = {{"method"}, {"cpu_ms", true}};
  AddIntervalColumns("recall", &columns);
  ResultTable table(columns);
  table.AddRow({"a|b", 12.5, 0.5, 0.25, 0.75});
  table.AddRow({"c", 200.4, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
  return table;
}

Experiment SmallExperiment() {
  return {"42_answer",
          "Is it so?",
          "Figure 42",
          "It is so.",
          "holds if it is so.",
          "1 s",
          [](const ExperimentContext& context) {
            ExperimentOutcome outcome;
            outcome.parameters = {{"seed", std::to_string(context.seed)}};
            outcome.table = SmallTable();
            outcome.figures = {{"42_answer", "title", "x", "y"}};
            outcome.figures[0].series = {{"a", {{1.0, {1.0, 0.5, 1.5}}}}};
            outcome.verdict = Verdict::kHolds;
            outcome.sentence = "It is so by +1.";
            return outcome;
          }};
}

ExperimentResult RunSmall(const testing::TempDir& folder) {
  ExperimentContext context;
  context.size = ExperimentSize::kFull;
  context.seed = 7;
  bool figures_drawn = false;
  return RunExperiment(SmallExperiment(), context, "0123456789", folder.path().string(),
                       &figures_drawn);
}

TEST(RunExperiment, WritesCsvJsonAndScript) {
  const testing::TempDir folder;
  const ExperimentResult result = RunSmall(folder);
  EXPECT_EQ(ReadTextFile(folder.File("42_answer.csv"), 1 << 20), SmallTable().Csv());
  EXPECT_EQ(ReadTextFile(folder.File("42_answer.json"), 1 << 20), ResultAsJson(result));
  EXPECT_THAT(ReadTextFile(folder.File("42_answer.gp"), 1 << 20), HasSubstr("$series0"));
  EXPECT_FALSE(result.commit.empty());
}

TEST(ExperimentResult, RoundTripsThroughJson) {
  const testing::TempDir folder;
  const ExperimentResult result = RunSmall(folder);
  const std::vector<ExperimentResult> read =
      ReadResults(folder.path().string(), {SmallExperiment()});
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(ResultAsJson(read[0]), ResultAsJson(result));
  EXPECT_EQ(read[0].seed, 7u);
  EXPECT_EQ(read[0].verdict, Verdict::kHolds);
  EXPECT_TRUE(std::isnan(std::get<double>(read[0].table.rows()[1][2])));
}

TEST(ExperimentResult, RefusesOtherText) {
  EXPECT_THROW(ResultFromJson("{", "x.json"), Error);
  EXPECT_THROW(ResultFromJson("{\"name\": 3}", "x.json"), Error);
}

TEST(Report, ShowsVerdictFigureAndTableWithTimingsLast) {
  const testing::TempDir folder;
  const std::string page =
      ReportAsMarkdown({SmallExperiment()}, {RunSmall(folder)}, "images/experiments");
  EXPECT_THAT(page, HasSubstr("| 42 | Figure 42 | [Is it so?](#42_answer) | holds |"));
  EXPECT_THAT(page, HasSubstr("**holds.** It is so by +1."));
  EXPECT_THAT(page, HasSubstr("![42_answer](images/experiments/42_answer.svg)"));
  EXPECT_THAT(page, HasSubstr("| method | recall | cpu_ms |\n|---|---|---|\n"
                              "| a\\|b | 0.5 [0.25, 0.75] | 12.5 |\n| c | - | 200 |\n"));
  EXPECT_THAT(page, HasSubstr("seed 7"));
}

TEST(Report, SaysWhatWasNotRun) {
  EXPECT_THAT(ReportAsMarkdown({SmallExperiment()}, {}, "images"), HasSubstr("| not run |"));
}

TEST(Report, SaysWhenResultsAreOfSeveralBuilds) {
  const testing::TempDir folder;
  const ExperimentResult result = RunSmall(folder);
  ExperimentResult other = result;
  other.commit = "fedcba9876";
  EXPECT_THAT(ReportAsMarkdown({SmallExperiment()}, {result, other}, "images"),
              HasSubstr("from 2 builds"));
  EXPECT_THAT(ReportAsMarkdown({SmallExperiment()}, {result, result}, "images"),
              Not(HasSubstr("builds")));
}

TEST(FindExperiment, KnowsNamesAndNumbers) {
  EXPECT_EQ(FindExperiment("7").name, FindExperiment("07").name);
  const Experiment eighteen = FindExperiment("18");
  EXPECT_EQ(FindExperiment(eighteen.name).title, eighteen.title);
}

TEST(FindExperiment, ListsTheNamesIfThereIsNone) {
  try {
    FindExperiment("99");
    FAIL() << "there is no experiment 99";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    for (const Experiment& experiment : AllExperiments()) {
      EXPECT_THAT(error.what(), HasSubstr(experiment.name));
    }
  }
}

TEST(AllExperiments, AreThoseOfThePaperAndOurOwnInOrder) {
  const std::vector<Experiment> experiments = AllExperiments();
  ASSERT_EQ(experiments.size(), 24u);
  for (size_t i = 0; i < experiments.size(); ++i) {
    EXPECT_EQ(std::stoi(experiments[i].name.substr(0, 2)), static_cast<int>(i + 1));
    EXPECT_FALSE(experiments[i].claim.empty());
  }
}

}  // namespace
}  // namespace cairn
