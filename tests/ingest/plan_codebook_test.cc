// Tests plans of a map that gets another codebook before they are published.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/error.h"
#include "ingest/codebook/shipped_codebook.h"
#include "ingest/codebook/train_codebook.h"
#include "ingest/maps/recode_map.h"
#include "ingest/plan_fixture.h"

namespace cairn {
namespace {

using ::testing::AllOf;
using testing::Failure;
using testing::FailureOf;
using ::testing::HasSubstr;
using testing::PlanOptionsFor;
using testing::Street;

class PlanCodebookTest : public testing::PlanFixture {
 protected:
  // Expects that publishing the plan is refused and leaves the map alone.
  static void ExpectRefusedForItsCodebook(const std::string& plan, MapStore* store) {
    const MapVersion version = store->Snapshot().version();
    const Failure failure = FailureOf([&] { Publish(plan, store); });
    EXPECT_EQ(failure.code, ErrorCode::kConflict);
    EXPECT_THAT(failure.message, AllOf(HasSubstr("another codebook"), HasSubstr("plan again")));
    EXPECT_EQ(store->Snapshot().version(), version);
  }
};
CAIRN_ON_BOTH_KINDS_OF_MAPS(PlanCodebookTest);

// The tiles of the plan are new, so only the codebook tells that the map has changed.
TEST_P(PlanCodebookTest, IsRefusedAfterTheMapWasRecoded) {
  MapStore store = MapStore::Create(Place("map"));
  IngestOptions trained = PlanOptionsFor("first");
  trained.codebook.source = CodebookSource::kTrained;
  Ingest(Street(1), trained, &store);
  const std::string plan = Plan(Street(2, 5000.0), PlanOptionsFor("second"), "plan", &store);
  Build(plan);
  RecodeMap(*ShippedCodebook(), &store, {});
  ExpectRefusedForItsCodebook(plan, &store);

  const std::string again = Plan(Street(2, 5000.0), PlanOptionsFor("second"), "again", &store);
  Build(again);
  Publish(again, &store);
  EXPECT_EQ(store.Snapshot().Sessions().size(), 2u);
  EXPECT_TRUE(store.Check({}).problems.empty());
}

TEST_P(PlanCodebookTest, IsRefusedAfterAnotherSessionBroughtTheFirstCodebook) {
  MapStore store = MapStore::Create(Place("map"));
  const std::string plan = Plan(Street(1), PlanOptionsFor("first"), "plan", &store);
  Build(plan);
  Ingest(Street(2, 5000.0), PlanOptionsFor("other"), &store);
  ExpectRefusedForItsCodebook(plan, &store);
}

}  // namespace
}  // namespace cairn
