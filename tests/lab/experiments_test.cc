// Runs every experiment at its quick size. The outcome must have a sentence, rows, parameters and
// figures.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "lab/experiments/runs/experiment_list.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

class QuickExperiment : public ::testing::TestWithParam<std::string> {
 protected:
  // The worlds are shared, as in `cairn-lab experiment all`.
  static void SetUpTestSuite() {
    folder_ = new testing::TempDir;
    worlds_ = new ExperimentWorlds(folder_->path().string());
  }
  static void TearDownTestSuite() {
    delete worlds_;
    delete folder_;
  }

  static testing::TempDir* folder_;
  static ExperimentWorlds* worlds_;
};
testing::TempDir* QuickExperiment::folder_ = nullptr;
ExperimentWorlds* QuickExperiment::worlds_ = nullptr;

TEST_P(QuickExperiment, RunsAndYieldsRows) {
  ExperimentContext context;
  context.worlds = worlds_;
  const ExperimentOutcome outcome = FindExperiment(GetParam()).run(context);
  EXPECT_FALSE(outcome.sentence.empty());
  if (outcome.verdict == Verdict::kNotBuilt) {
    EXPECT_TRUE(outcome.table.rows().empty());
    return;
  }
  EXPECT_GE(outcome.table.rows().size(), 2u);
  EXPECT_FALSE(outcome.parameters.empty());
  ASSERT_FALSE(outcome.figures.empty());
  for (const Figure& figure : outcome.figures) {
    ASSERT_FALSE(figure.series.empty());
    EXPECT_FALSE(figure.series.front().points.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(All, QuickExperiment, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const Experiment& experiment : AllExperiments()) {
                             names.push_back(experiment.name);
                           }
                           return names;
                         }()),
                         [](const auto& test) { return "Experiment_" + test.param; });

}  // namespace
}  // namespace cairn
