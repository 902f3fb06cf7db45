// How the work on a map grows with its tiles. The payloads are empty, so only the tables count.
//
//   cairn_storage_bench --benchmark_filter=Map
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "storage/map/internal/map_file.h"
#include "storage/map/internal/sqlite_database.h"
#include "storage/map/internal/version_queries.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr int64_t kTilesASearch = 16;  // TilesOptions::max_tiles.

// A tile of a grid of `num_columns`, about 150 m apart. The payload is the tile's number alone.
void PutEmptyTile(int64_t number, int64_t num_columns, MapUpdate* update) {
  TileRecord tile;
  tile.tile_id = TileId::Containing(
      Geodetic::FromDegrees(49.0 + 0.00135 * static_cast<double>(number / num_columns),
                            8.0 + 0.00206 * static_cast<double>(number % num_columns), 0.0));
  tile.codebook_id = CodebookId(1);
  tile.landmark_bounds = tile.tile_id.Bounds();
  std::vector<uint8_t> payload(sizeof(number));
  std::memcpy(payload.data(), &number, sizeof(number));
  update->PutTile(tile, payload);
}

// A map of about `count` tiles; some places of the grid fall into one tile.
const MapStore& MapOfTiles(int64_t count) {
  static const testing::TempDir dir;
  static std::map<int64_t, MapStore> stores;
  const auto found = stores.find(count);
  if (found != stores.end()) {
    return found->second;
  }
  MapStore store = MapStore::Create(dir.File(std::to_string(count) + ".gpkg"));
  MapUpdate update = store.BeginUpdate();
  update.AddCodebook(testing::RandomCodebook());
  const auto num_columns = static_cast<int64_t>(std::sqrt(static_cast<double>(count)));
  for (int64_t i = 0; i < count; ++i) {
    PutEmptyTile(i, num_columns, &update);
  }
  update.Publish();
  return stores.emplace(count, std::move(store)).first->second;
}

void MapInfoOfVersion(benchmark::State& state) {
  const MapStore& store = MapOfTiles(state.range(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(store.Snapshot().Info());
  }
  state.counters["tiles"] = static_cast<double>(store.Snapshot().Info().num_tiles);
}

void MapQueryWithoutPrior(benchmark::State& state) {
  const MapStore& store = MapOfTiles(state.range(0));
  for (auto _ : state) {
    const MapSnapshot snapshot = store.Snapshot();
    benchmark::DoNotOptimize(snapshot.CurrentCodebook());
    benchmark::DoNotOptimize(snapshot.Info());
    benchmark::DoNotOptimize(snapshot.AllTiles(kTilesASearch));
  }
}

void MapQueryWithPrior(benchmark::State& state) {
  const MapStore& store = MapOfTiles(state.range(0));
  const GeoBox box = BoxAround(Geodetic::FromDegrees(49.005, 8.01, 0.0), 150.0);
  for (auto _ : state) {
    const MapSnapshot snapshot = store.Snapshot();
    benchmark::DoNotOptimize(snapshot.CurrentCodebook());
    benchmark::DoNotOptimize(snapshot.FindTiles(box));
  }
}

// Publishes a thousand updates of a tile each. The counters are the tiles a minute over the first
// and over the last hundred.
void MapOneTileAnUpdate(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  constexpr int kNumTiles = 1000;
  constexpr int kWindow = 100;
  for (auto _ : state) {
    const testing::TempDir dir;
    MapStore store = MapStore::Create(dir.File("a.gpkg"));
    std::vector<Clock::time_point> times = {Clock::now()};
    for (int i = 0; i < kNumTiles; ++i) {
      MapUpdate update = store.BeginUpdate();
      if (i == 0) {
        update.AddCodebook(testing::RandomCodebook());
      }
      PutEmptyTile(i, 40, &update);
      update.Publish();
      times.push_back(Clock::now());
    }
    const auto tiles_a_minute = [&](int first) {
      return 60.0 * kWindow /
             std::chrono::duration<double>(times[first + kWindow] - times[first]).count();
    };
    state.counters["first_a_minute"] = tiles_a_minute(0);
    state.counters["last_a_minute"] = tiles_a_minute(kNumTiles - kWindow);
  }
}

// What an update pays in addition if it removes a tile at the edge of the map.
void MapBoundsAnew(benchmark::State& state) {
  sqlite::Access access = sqlite::Access::kReadOnly;
  SqliteDatabase database(OpenMapFile(MapOfTiles(state.range(0)).path(), &access));
  for (auto _ : state) {
    benchmark::DoNotOptimize(queries::BoundsOfTiles(&database));
  }
}

BENCHMARK(MapInfoOfVersion)->Arg(100)->Arg(100'000)->Unit(benchmark::kMicrosecond);
BENCHMARK(MapQueryWithoutPrior)->Arg(100)->Arg(100'000)->Unit(benchmark::kMicrosecond);
BENCHMARK(MapQueryWithPrior)->Arg(100)->Arg(100'000)->Unit(benchmark::kMicrosecond);
BENCHMARK(MapBoundsAnew)->Arg(100)->Arg(100'000)->Unit(benchmark::kMicrosecond);
BENCHMARK(MapOneTileAnUpdate)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace cairn
