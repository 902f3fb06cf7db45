// Tests that an ingest and a merge decode and index each tile once.
#include "ingest/place/tile_memory.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "ingest/maps/meet_maps.h"
#include "ingest/maps/merge_source.h"
#include "ingest/plan_fixture.h"
#include "support/expect_error.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::PlanOptionsFor;
using testing::Street;

class TileMemoryTest : public ::testing::Test {
 protected:
  MapStore MakeMap(const std::string& name) {
    MapStore store = MapStore::Create(dir_.File(name));
    Ingest(Street(1), "first", &store);
    return store;
  }

  // Returns the memory of the ingest.
  static std::shared_ptr<TileMemory> Ingest(const testing::StreetWorld& world,
                                            const std::string& session_name, MapStore* store) {
    std::shared_ptr<TileMemory> memory;
    IngestSession(world.Reconstruct(), world.EcefFromWorld(), PlanOptionsFor(session_name), store,
                  {}, [&](const PlannedSession& planned) { memory = planned.known->memory(); });
    return memory;
  }

  static std::vector<TileRecord> TilesOf(const MapStore& store) {
    return store.Snapshot().AllTiles(std::numeric_limits<int64_t>::max());
  }

  testing::TempDir dir_;
};

TEST_F(TileMemoryTest, AnIngestDecodesAndIndexesEachTileOnce) {
  MapStore store = MakeMap("map.gpkg");
  const std::vector<TileRecord> stored = TilesOf(store);
  ASSERT_GT(stored.size(), 1u);
  const std::shared_ptr<TileMemory> memory = Ingest(Street(2), "second", &store);
  EXPECT_EQ(memory->num_decoded(), std::ssize(stored));
  // The comparison searches the stored tiles, the gate those that are built.
  EXPECT_EQ(memory->searchable()->Stats().num_misses, 2 * stored.size());
}

TEST_F(TileMemoryTest, AnIngestThatReplacesASessionDecodesEachTileOnce) {
  MapStore store = MakeMap("map.gpkg");
  Ingest(Street(2), "second", &store);
  const std::vector<TileRecord> stored = TilesOf(store);
  const std::shared_ptr<TileMemory> memory = Ingest(Street(3), "second", &store);
  EXPECT_EQ(memory->num_decoded(), std::ssize(stored));
}

TEST_F(TileMemoryTest, TheGateAsksWhatIsPublished) {
  MapStore store = MakeMap("map.gpkg");
  const std::shared_ptr<TileMemory> memory = Ingest(Street(2), "second", &store);
  const MapSnapshot snapshot = store.Snapshot();
  for (const TileRecord& record : TilesOf(store)) {
    const auto asked = memory->Made(record.digest, [] {
      ADD_FAILURE() << "is not in the memory";
      return DecodedTile();
    });
    const DecodedTile published = DecodePayload(snapshot.LoadPayload(record.payload_id));
    EXPECT_TRUE(testing::SameTile(asked->tile, published.tile));
    EXPECT_EQ(asked->lists, published.lists);
  }
}

TEST_F(TileMemoryTest, AMergeDecodesEachTileOnce) {
  const MapStore of_a = MakeMap("a.gpkg");
  MapStore of_b = MapStore::Create(dir_.File("b.gpkg"));
  Ingest(Street(2), "second", &of_b);
  const auto memory = std::make_shared<TileMemory>();
  const MergeSource a(of_a, memory);
  MergeSource b(of_b, memory);
  b.RecodeTo(a.codebook());
  std::vector<TileId> tiles;
  for (const TileRecord& record : TilesOf(of_a)) {
    tiles.push_back(record.tile_id);
  }
  EXPECT_GT(CompareMaps(a, b, 1).num_localized, 0);
  EXPECT_FALSE(LinkMaps(a, b, tiles, DescriptorCodec(a.codebook()), LinkOptions()).empty());
  EXPECT_EQ(memory->num_decoded(), std::ssize(TilesOf(of_a)) + std::ssize(TilesOf(of_b)));
  EXPECT_EQ(memory->searchable()->Stats().num_misses, TilesOf(of_a).size());
}

TEST_F(TileMemoryTest, RefusesThePayloadOfAnotherTile) {
  const MapStore store = MakeMap("map.gpkg");
  const MapSnapshot snapshot = store.Snapshot();
  const RememberedTiles remembered(snapshot, std::make_shared<TileMemory>());
  std::vector<TileRecord> stored = TilesOf(store);
  stored[0].payload_id = stored[1].payload_id;
  EXPECT_EQ(testing::ErrorCodeOf([&] { remembered.Decoded(stored[0]); }), ErrorCode::kMapDamaged);
}

}  // namespace
}  // namespace cairn
