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
  metrics.CountLocalize(late, ServerTimes{}, /*is_stale=*/false);
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
  metrics.CountLocalize(result, {.decode_seconds = 0.01, .extract_seconds = 0.03},
                        /*is_stale=*/false);
  const std::string text = metrics.Render({});
  EXPECT_THAT(text, HasSubstr("cairn_stage_seconds_count{stage=\"matching\"} 1"));
  EXPECT_THAT(text, HasSubstr("cairn_stage_seconds_count{stage=\"extraction\"} 1"));
  EXPECT_THAT(text, HasSubstr("cairn_stage_seconds_count{stage=\"voting\"} 0"));
}

// Whoever makes many keys does not make as many series.
TEST(Metrics, LabelsAreBounded) {
  Metrics metrics;
  for (size_t i = 0; i < Metrics::kMaxLabels + 10; ++i) {
    metrics.CountClient("k" + std::to_string(i), 200);
  }
  metrics.CountClient("k0", 429);
  const std::string text = metrics.Render({});
  EXPECT_THAT(text, HasSubstr("cairn_client_requests_total{label=\"k0\",status=\"200\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("cairn_client_requests_total{label=\"k0\",status=\"429\"} 1\n"));
  EXPECT_THAT(text,
              HasSubstr("cairn_client_requests_total{label=\"(other)\",status=\"200\"} 10\n"));
}

// Who replaces keys now and then does not run out of labels.
TEST(Metrics, LabelsOfFormerKeysAreForgotten) {
  Metrics metrics;
  for (size_t i = 0; i < 2 * Metrics::kMaxLabels; ++i) {
    metrics.CountClient("old" + std::to_string(i), 200);
  }
  metrics.KeepClients({"old1", "new"});
  metrics.CountClient("new", 200);
  const std::string text = metrics.Render({});
  EXPECT_THAT(text, HasSubstr("cairn_client_requests_total{label=\"new\",status=\"200\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("cairn_client_requests_total{label=\"old1\",status=\"200\"} 1\n"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("old0")));
}

TEST(Metrics, OnlyQueriesThatLoadedTilesFetched) {
  Metrics metrics;
  LocalizeResult warm;
  warm.times.seconds[static_cast<size_t>(Stage::kTiles)] = 0.001;
  LocalizeResult cold = warm;
  cold.counters.num_tiles_loaded = 4;
  metrics.CountLocalize(warm, {}, /*is_stale=*/false);
  metrics.CountLocalize(cold, {}, /*is_stale=*/true);
  const std::string text = metrics.Render({});
  EXPECT_THAT(text, HasSubstr("cairn_fetch_seconds_count 1"));
  EXPECT_THAT(text, HasSubstr("cairn_stale_answers_total 1"));
}

TEST(Metrics, ErrorsOfTheStoreAreThoseThatRequestsDoNotCause) {
  Metrics metrics;
  metrics.CountError(ErrorCode::kMapDamaged);
  metrics.CountError(ErrorCode::kBadInput);
  const std::string text = metrics.Render({});
  EXPECT_THAT(text, HasSubstr("cairn_store_errors_total{code=\"map_damaged\"} 1"));
  EXPECT_THAT(text, HasSubstr("cairn_store_errors_total{code=\"unavailable\"} 0"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("bad_input")));
}

TEST(Metrics, TheStateIsShown) {
  ServerState state;
  EXPECT_THAT(Metrics().Render(state), HasSubstr("cairn_map_readable 0"));
  state.head = {.version = MapVersion(7), .created_unix_s = 1'763'983'556.0, .is_stale = true};
  state.is_degraded = state.is_draining = true;
  state.num_waiting = 3;
  const std::string text = Metrics().Render(state);
  for (const char* line :
       {"cairn_map_readable 1", "cairn_map_version 7", "cairn_map_stale 1", "cairn_map_degraded 1",
        "cairn_draining 1", "cairn_map_version_created_timestamp_seconds 1763983556",
        "cairn_queries_waiting 3"}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

}  // namespace
}  // namespace cairn
