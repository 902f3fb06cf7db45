#include "http/service/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn {
namespace {

using ::testing::HasSubstr;

TEST(Metrics, AQueryWhoseTurnCameTooLateRanNoStage) {
  Metrics metrics;
  LocalizeResult late;
  late.reason = NotLocalizedReason::kTimeout;
  metrics.CountLocalize(late, ServerTimes{});
  const std::string text = metrics.Render({});
  EXPECT_THAT(text, HasSubstr("cairn_localize_total{outcome=\"TIMEOUT\"} 1"));
  for (const char* stage :
       {"prior", "tiles", "matching", "voting", "pose", "refinement", "extraction"}) {
    EXPECT_THAT(text,
                HasSubstr("cairn_stage_seconds_count{stage=\"" + std::string(stage) + "\"} 0"));
  }
}

TEST(Metrics, StagesThatRanCountAndOthersDoNot) {
  Metrics metrics;
  LocalizeResult result;
  result.reason = NotLocalizedReason::kTooFewMatches;
  result.times.seconds[static_cast<size_t>(Stage::kMatching)] = 0.02;
  metrics.CountLocalize(result, {.decode_seconds = 0.01, .extract_seconds = 0.03});
  MapMetrics map;
  map.is_degraded = true;
  const std::string text = metrics.Render(map);
  EXPECT_THAT(text, HasSubstr("cairn_stage_seconds_count{stage=\"matching\"} 1"));
  EXPECT_THAT(text, HasSubstr("cairn_stage_seconds_count{stage=\"extraction\"} 1"));
  EXPECT_THAT(text, HasSubstr("cairn_stage_seconds_count{stage=\"voting\"} 0"));
  EXPECT_THAT(text, HasSubstr("cairn_map_degraded 1"));
}

}  // namespace
}  // namespace cairn
