// The accuracy of sessions: kept with them through versions and copies; maps without the table.
#include "storage/map/session_accuracy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/error.h"
#include "storage/map/copy_map.h"
#include "storage/map/map_history.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/map_place.h"
#include "support/raw_sql.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::NamedSession;

constexpr SessionAccuracy kGood = {0.01, 0.5, 0.002}, kPoor = {0.03, 4.0, 0.01};

SessionRecord SessionOf(const std::string& name, const SessionAccuracy& accuracy) {
  SessionRecord session = NamedSession(name);
  session.accuracy = accuracy;
  return session;
}

// What maps of earlier programs lack.
constexpr const char* kForgetTable =
    "DROP TABLE session_accuracy;"
    "DELETE FROM gpkg_extensions WHERE table_name = 'session_accuracy'";

class SessionAccuracyTest : public testing::MapPlaceTest {};
CAIRN_ON_BOTH_KINDS_OF_MAPS(SessionAccuracyTest);

TEST_P(SessionAccuracyTest, BelongsToTheSessionInEachVersion) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate add = store.BeginUpdate();
  const SessionId good = add.AddSession(SessionOf("good", kGood));
  const SessionId unknown = add.AddSession(NamedSession("unknown"));
  add.AddSession(SessionOf("poor", kPoor));
  EXPECT_EQ(add.Sessions().at(0).accuracy, kGood);
  const MapVersion with = add.Publish();
  const MapSnapshot before = store.Snapshot();
  EXPECT_EQ(before.Sessions().at(0).accuracy, kGood);
  EXPECT_FALSE(before.Sessions().at(1).accuracy);
  EXPECT_EQ(before.FindSession("poor")->accuracy, kPoor);
  EXPECT_THAT(before.AccuraciesOf({good, unknown}), ElementsAre(kGood));

  MapUpdate remove = store.BeginUpdate();
  remove.RemoveSession(good);
  remove.Publish();
  EXPECT_EQ(before.FindSession("good")->accuracy, kGood);
  RollBack(with, &store);
  EXPECT_EQ(store.Snapshot().FindSession("good")->accuracy, kGood);
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

TEST_P(SessionAccuracyTest, GoesWithTheLastVersionOfItsSession) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate add = store.BeginUpdate();
  const SessionId good = add.AddSession(SessionOf("good", kGood));
  const SessionId poor = add.AddSession(SessionOf("poor", kPoor));
  add.Publish();
  MapUpdate remove = store.BeginUpdate();
  remove.RemoveSession(good);
  remove.Publish();
  Prune({.keep = 1}, &store);
  EXPECT_THAT(store.Snapshot().AccuraciesOf({good, poor}), ElementsAre(kPoor));
}

TEST_P(SessionAccuracyTest, IsCopied) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate add = store.BeginUpdate();
  add.AddSession(SessionOf("good", kGood));
  add.Publish();
  CopyMap(Place("a"), Place("b"), {});
  const MapStore copy = MapStore::Open(Place("b"), OpenMode::kReadOnly);
  EXPECT_EQ(copy.Snapshot().FindSession("good")->accuracy, kGood);
  EXPECT_THAT(copy.Check({}).problems, IsEmpty());
}

TEST_P(SessionAccuracyTest, RefusesImpossibleNumbers) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate add = store.BeginUpdate();
  for (const SessionAccuracy& accuracy :
       {SessionAccuracy{-1.0, 0.0, 0.0}, SessionAccuracy{0.0, std::nan(""), 0.0},
        SessionAccuracy{0.0, 0.0, 1e9}}) {
    EXPECT_EQ(ErrorCodeOf([&] { add.AddSession(SessionOf("a", accuracy)); }),
              ErrorCode::kInvalidArgument);
  }
  add.AddSession(SessionOf("a", kGood));
  add.Publish();
  testing::ExecuteRaw(Place("a"), "UPDATE session_accuracy SET on_earth_m = -1");
  EXPECT_THAT(store.Check({}).problems, ElementsAre(HasSubstr("impossible accuracy")));
  EXPECT_EQ(ErrorCodeOf([&] { store.Snapshot().Sessions(); }), ErrorCode::kMapDamaged);
}

TEST(SessionAccuracyOfOldMaps, IsUnknownUntilTheNextSession) {
  const testing::TempDir dir;
  const std::string path = dir.File("a.gpkg");
  {
    MapStore store = MapStore::Create(path);
    MapUpdate add = store.BeginUpdate();
    add.AddSession(NamedSession("old"));
    add.Publish();
  }
  testing::ExecuteRaw(path, kForgetTable);
  MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
  EXPECT_FALSE(store.Snapshot().FindSession("old")->accuracy);
  EXPECT_THAT(store.Snapshot().AccuraciesOf({SessionId(1)}), IsEmpty());
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
  CopyMap(path, dir.File("copy.gpkg"), {});

  MapUpdate add = store.BeginUpdate();
  add.AddSession(SessionOf("new", kGood));
  add.Publish();
  EXPECT_EQ(store.Snapshot().FindSession("new")->accuracy, kGood);
  EXPECT_FALSE(store.Snapshot().FindSession("old")->accuracy);
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
  MapStore::Open(path, OpenMode::kReadOnly);
}

TEST(SessionAccuracy, MeansAreOfSquares) {
  const SessionAccuracy mean = RootMeanSquare({{3.0, 0.0, 1.0}, {4.0, 0.0, 1.0}});
  EXPECT_DOUBLE_EQ(mean.in_map_m, std::sqrt(12.5));
  EXPECT_EQ(mean.on_earth_m, 0.0);
  EXPECT_DOUBLE_EQ(mean.on_earth_rad, 1.0);
}

}  // namespace
}  // namespace cairn
