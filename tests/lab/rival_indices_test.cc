// The rivals keep the contract of MatchingIndex, and the engine finds poses with them.
#include <string>
#include <vector>

#include "core/angles.h"
#include "engine/mapped_streets.h"
#include "engine/matching_index_suite.h"
#include "engine/simple_tile.h"
#include "lab/rivals/covisibility_filter.h"
#include "lab/rivals/index_methods.h"

namespace cairn {
namespace {

constexpr IndexMethod kRivals[] = {IndexMethod::kInvertedMultiIndex, IndexMethod::kKdTree};

std::vector<testing::IndexUnderTest> RivalIndices() {
  std::vector<testing::IndexUnderTest> rivals;
  for (const IndexMethod method : kRivals) {
    IndexMethodOptions options;
    options.multi_index.num_words = 50;
    options.multi_index.num_probes = 200;
    IndexMethodOptions complete = options;
    complete.multi_index.num_probes = 1'000'000;
    complete.kd_tree.num_probes = 1'000'000;
    rivals.push_back({IndexMethodName(method), MakeIndexOptions(method, options),
                      MakeIndexOptions(method, complete)});
  }
  return rivals;
}

INSTANTIATE_TEST_SUITE_P(Rivals, MatchingIndexTest, ::testing::ValuesIn(RivalIndices()),
                         [](const auto& test) { return test.param.name; });

class LocalizerWithRivals : public testing::OneStreetTest {};

TEST_F(LocalizerWithRivals, FindsThePose) {
  std::vector<LocalizerOptions> alternatives;
  for (const IndexMethod method : kRivals) {
    alternatives.emplace_back().matching.index = MakeIndexOptions(method);
  }
  alternatives.emplace_back().voting = WithCovisibility({});
  const Rigid3d cam_from_enu = testing::QueryPose(20.0);
  for (const LocalizerOptions& options : alternatives) {
    const LocalizeResult result =
        map_->WithOptions(options).Localize(testing::QueryAt(*world_, cam_from_enu));
    testing::ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  }
}

}  // namespace
}  // namespace cairn
