// Tests queries whose version of the map is pruned while they run.
#include <gtest/gtest.h>

#include <future>
#include <latch>
#include <memory>
#include <optional>
#include <thread>

#include "core/angles.h"
#include "core/error.h"
#include "engine/mapped_streets.h"
#include "ingest/maps/remove_session.h"
#include "storage/map/map_history.h"
#include "support/map_builder.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::ExpectPose;
using testing::MappedStreets;
using testing::QueryAt;
using testing::QueryPose;
using testing::StreetWorld;

// A map whose first version with a street is pruned.
class LocalizerPrune : public ::testing::Test {
 protected:
  LocalizerPrune() : map_({world_}) {}

  // Ingests the street once more under another name, and leaves no other version. The tiles have
  // other landmark ids, so they have other payloads.
  void ReplaceAndPrune() {
    MapStore writer = MapStore::Open(map_.store().path(), OpenMode::kReadWrite);
    RemoveSession("street 0", &writer);
    map_.Add(world_);
    Prune({.keep = 1}, &writer);
  }

  std::shared_ptr<const MapStore> store() const {
    return {std::shared_ptr<const MapStore>(), &map_.store()};
  }

  const StreetWorld world_;
  MappedStreets map_;
  const Rigid3d cam_from_enu_ = QueryPose(20.0);
  const LocalizeQuery query_ = QueryAt(world_, cam_from_enu_);
  const std::shared_ptr<TileCache> cache_ = std::make_shared<TileCache>(size_t{1} << 28);
};

// The query has found its tiles in the old version, and waits for a payload, when the payload goes.
TEST_F(LocalizerPrune, AQueryWhosePayloadIsGoneIsAnsweredFromTheLatestVersion) {
  const Localizer localizer(store(), {}, cache_);
  const LocalizeResult before = map_.localizer().Localize(query_);
  ASSERT_TRUE(before.localized);
  const MapSnapshot old = map_.store().Snapshot();
  const std::optional<TileRecord> record = old.FindTile(before.tiles.front());
  ASSERT_TRUE(record);

  std::latch is_loading(1), is_pruned(1);
  const auto load = [&]() -> std::shared_ptr<const SearchableTile> {
    is_loading.count_down();
    is_pruned.wait();
    old.LoadPayload(record->payload_id);
    return nullptr;
  };
  std::future<std::optional<ErrorCode>> failure = std::async(std::launch::async, [&] {
    return ErrorCodeOf([&] { cache_->GetOrLoad(record->digest, load); });
  });
  is_loading.wait();
  std::future<LocalizeResult> answer =
      std::async(std::launch::async, [&] { return localizer.Localize(query_); });
  while (cache_->Stats().num_hits == 0) {  // Until the query waits for that load.
    std::this_thread::yield();
  }
  ReplaceAndPrune();
  is_pruned.count_down();

  EXPECT_EQ(failure.get(), ErrorCode::kUnavailable);
  const LocalizeResult result = answer.get();
  ExpectPose(result, world_, cam_from_enu_, 0.05, 0.1 * kRadPerDeg);
  EXPECT_EQ(result.map_version, map_.store().Snapshot().version());
  EXPECT_NE(result.map_version, before.map_version);
}

TEST_F(LocalizerPrune, APrunedVersionThatWasAskedForIsUnavailable) {
  const Localizer localizer(store(), {}, cache_);
  const MapSnapshot old = map_.store().Snapshot();
  EXPECT_TRUE(map_.localizer().LocalizeIn(old, query_).localized);
  ReplaceAndPrune();
  EXPECT_EQ(ErrorCodeOf([&] { localizer.LocalizeIn(old, query_); }), ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace cairn
