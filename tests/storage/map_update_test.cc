// What updates do with sessions and keyframes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.h"
#include "storage/map/copy_map.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/map_place.h"
#include "support/street_map.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::IsEmpty;
using testing::KeyframeAt;
using testing::NamedSession;

class MapUpdateTest : public testing::MapPlaceTest {};
CAIRN_ON_BOTH_KINDS_OF_MAPS(MapUpdateTest);

TEST_P(MapUpdateTest, SessionsHaveATimeAndADigest) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate update = store.BeginUpdate();
  update.AddSession(NamedSession("a"));
  SessionRecord session = NamedSession("b");
  for (const char* no_time : {"in May", "2026-02-30T00:00:00Z", "2026-01-31 12:00:00"}) {
    session.recorded_at = no_time;
    EXPECT_EQ(ErrorCodeOf([&] { update.AddSession(session); }), ErrorCode::kInvalidArgument);
  }
  session.recorded_at = "2026-01-31T12:00:00Z";
  session.content_digest = "0xFF";
  EXPECT_EQ(ErrorCodeOf([&] { update.AddSession(session); }), ErrorCode::kInvalidArgument);
  session.content_digest = "ff";
  update.AddSession(session);
  const std::vector<SessionRecord> sessions = update.Sessions();
  ASSERT_EQ(sessions.size(), 2u);
  EXPECT_EQ(sessions[0].recorded_at, sessions[0].created_at);
  EXPECT_EQ(sessions[1].recorded_at, "2026-01-31T12:00:00Z");
  update.Publish();
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

TEST_P(MapUpdateTest, KeyframesOfATileCanBeRemovedOneByOne) {
  MapStore store = MapStore::Create(Place("a"));
  const Geodetic here = Geodetic::FromDegrees(49.0, 8.4, 100.0);
  const Geodetic elsewhere = Geodetic::FromDegrees(49.1, 8.4, 100.0);
  MapUpdate update = store.BeginUpdate();
  const SessionId session = update.AddSession(NamedSession("a"));
  const KeyframeId first = update.AddKeyframe(KeyframeAt(here, session));
  const KeyframeId second = update.AddKeyframe(KeyframeAt(here, session));
  update.AddKeyframe(KeyframeAt(elsewhere, session));
  const auto ids_here = [&] {
    std::vector<KeyframeId> ids;
    for (const KeyframeRecord& keyframe : update.KeyframesOfTile(TileId::Containing(here))) {
      ids.push_back(keyframe.id);
    }
    return ids;
  };
  EXPECT_THAT(ids_here(), ElementsAre(first, second));
  update.RemoveKeyframe(first);
  update.RemoveKeyframe(first);  // Is not there any more, which is no fault.
  EXPECT_THAT(ids_here(), ElementsAre(second));
  update.Publish();
  EXPECT_EQ(store.Snapshot().KeyframesOfSession(session).size(), 2u);
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

TEST_P(MapUpdateTest, ReservedIdsAreGivenToNobodyElse) {
  MapStore store = MapStore::Create(Place("a"));
  const IdCounts counts = {.num_sessions = 2, .num_keyframes = 10, .num_landmarks = 100};
  const FirstIds first = store.ReserveIds(counts);
  const FirstIds second = store.ReserveIds(counts);
  EXPECT_EQ(store.Snapshot().version(), MapVersion(1));
  EXPECT_EQ(Value(second.session), Value(first.session) + 2);
  EXPECT_EQ(Value(second.keyframe), Value(first.keyframe) + 10);
  EXPECT_EQ(Value(second.landmark), Value(first.landmark) + 100);
  MapUpdate update = store.BeginUpdate();
  const SessionId fresh = update.AddSession(NamedSession("fresh"));
  EXPECT_EQ(Value(fresh), Value(second.session) + 2);
  EXPECT_EQ(update.AddSession(NamedSession("reserved"), first.session), first.session);
  KeyframeRecord keyframe = KeyframeAt(Geodetic::FromDegrees(47.0, 8.0, 400.0), fresh);
  EXPECT_EQ(Value(update.AddKeyframe(keyframe)), Value(second.keyframe) + 10);
  EXPECT_EQ(update.AddKeyframe(keyframe, first.keyframe), first.keyframe);
  EXPECT_EQ(Value(update.NextIds().keyframe), Value(second.keyframe) + 11);
  update.Publish();
  EXPECT_EQ(Value(store.ReserveIds({.num_sessions = 1}).session), Value(fresh) + 1);
  EXPECT_TRUE(store.Check({}).problems.empty());
}

// Past versions have rows with the largest ids, and a plan has ids that no row has yet.
TEST_P(MapUpdateTest, ACopyGivesOutNoIdThatTheMapEverGave) {
  const Geodetic here = Geodetic::FromDegrees(49.0, 8.4, 100.0);
  MapStore store = MapStore::Create(Place("a"));
  const auto add = [&](const std::string& name) {
    MapUpdate update = store.BeginUpdate();
    const SessionId session = update.AddSession(NamedSession(name));
    update.AddKeyframe(KeyframeAt(here, session));
    update.AddKeyframe(KeyframeAt(here, session));
    update.Publish();
    return session;
  };
  add("kept");
  const SessionId removed = add("removed");
  {
    MapUpdate update = store.BeginUpdate();
    update.RemoveSession(removed);
    update.Publish();
  }
  store.ReserveIds(
      {.num_codebooks = 3, .num_sessions = 2, .num_keyframes = 10, .num_landmarks = 100});
  CopyMap(Place("a"), Place("b"), {});
  MapStore copy = MapStore::Open(Place("b"), OpenMode::kReadWrite);
  const FirstIds next = store.ReserveIds({});
  const FirstIds next_of_copy = copy.ReserveIds({});
  EXPECT_EQ(next_of_copy.codebook, next.codebook);
  EXPECT_EQ(next_of_copy.session, next.session);
  EXPECT_EQ(next_of_copy.keyframe, next.keyframe);
  EXPECT_EQ(next_of_copy.landmark, next.landmark);
  EXPECT_EQ(Value(next_of_copy.session), Value(removed) + 3);
  EXPECT_TRUE(copy.Check({}).problems.empty());
}

}  // namespace
}  // namespace cairn
