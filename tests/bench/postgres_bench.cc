// What reads of a map on a PostgreSQL server take. The server is thrown away at the end; it listens
// on a socket of this machine.
//
//   cairn_storage_bench --benchmark_filter=Postgres
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/angles.h"
#include "storage/database/postgres/server.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/postgres_cluster.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using Clock = std::chrono::steady_clock;
using testing::PostgresCluster;

constexpr double kRowDeg = 0.00135, kColumnDeg = 0.00206;  // About 150 m.
constexpr int64_t kTilesAStatement = 2000;

TileId TileOf(int64_t number, int64_t num_columns) {
  return TileId::Containing(
      Geodetic::FromDegrees(49.0 + kRowDeg * static_cast<double>(number / num_columns),
                            7.0 + kColumnDeg * static_cast<double>(number % num_columns), 0.0));
}

// Inserts tiles that all have payload 1, by plain SQL.
void InsertEmptyTiles(const std::string& url, int64_t count, int64_t num_columns) {
  const auto connection = postgres::Server(url).Connect(postgres::Use::kWrite, {});
  for (int64_t first = 0; first < count; first += kTilesAStatement) {
    std::string squares, tiles;
    for (int64_t i = first; i < std::min(count, first + kTilesAStatement); ++i) {
      const TileId id = TileOf(i, num_columns);
      const GeoBox box = id.Bounds();
      const std::string comma = squares.empty() ? "" : ",";
      squares += fmt::format("{}({},'{}',0,0,0,0,0,0,ST_MakeEnvelope({},{},{},{},4326))", comma,
                             id.value(), id.ToString(), box.west_rad * kDegPerRad,
                             box.south_rad * kDegPerRad, box.east_rad * kDegPerRad,
                             box.north_rad * kDegPerRad);
      tiles += fmt::format("{}({},1,1,0,0,0,0,2)", comma, id.value());
    }
    connection->Execute(
        "INSERT INTO coverage (tile_id, tile, num_landmarks, num_descriptors, num_keyframes, "
        "num_bytes, min_h_m, max_h_m, geom) VALUES " +
        squares + " ON CONFLICT DO NOTHING; INSERT INTO cairn_tiles VALUES " + tiles +
        " ON CONFLICT DO NOTHING");
  }
  connection->Execute("ANALYZE");
}

std::string ServerMapOfTiles(int64_t count) {
  static std::map<int64_t, std::string> urls;
  std::string& url = urls[count];
  if (url.empty()) {
    url = PostgresCluster::Shared().CreateDatabase("tiles" + std::to_string(count));
    MapStore store = MapStore::Create(url);
    MapUpdate update = store.BeginUpdate();
    update.AddCodebook(testing::RandomCodebook());
    testing::AddTile(testing::RandomTile(), &update);
    update.Publish();
    InsertEmptyTiles(url, count, static_cast<int64_t>(std::sqrt(static_cast<double>(count))));
  }
  return url;
}

template <typename Work>
double MicrosecondsOf(const Work& work) {
  const Clock::time_point begin = Clock::now();
  work();
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

double Percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

// Searches around random places, hardly any of which is in the cache, because each map is opened
// anew for 50 of them. Counts the first search of each connection apart: the server's process has
// to find the tables then. After each search, reads one number, for what a round trip alone takes.
void PostgresFindTiles(benchmark::State& state) {
  constexpr int kNumStores = 20, kSearchesAStore = 50;
  const std::string url = ServerMapOfTiles(state.range(0));
  const double side = std::sqrt(static_cast<double>(state.range(0)));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0.0, side);
  std::vector<double> first_us, times_us, trips_us;
  for (auto _ : state) {
    for (int i = 0; i < kNumStores; ++i) {
      const MapStore store = MapStore::Open(url, OpenMode::kServing);
      for (int k = 0; k <= kSearchesAStore; ++k) {
        const double row = place(random), column = place(random);
        const GeoBox box = BoxAround(
            Geodetic::FromDegrees(49.0 + kRowDeg * row, 7.0 + kColumnDeg * column, 0.0), 100.0);
        (k == 0 ? first_us : times_us).push_back(MicrosecondsOf([&] {
          benchmark::DoNotOptimize(store.Snapshot().FindTiles(box));
        }));
        trips_us.push_back(
            MicrosecondsOf([&] { benchmark::DoNotOptimize(store.Snapshot().NextLandmarkId()); }));
      }
    }
  }
  state.counters["first_us"] = Percentile(first_us, 0.5);
  state.counters["p50_us"] = Percentile(times_us, 0.5);
  state.counters["p99_us"] = Percentile(times_us, 0.99);
  state.counters["trip_p50_us"] = Percentile(trips_us, 0.5);
  state.counters["trip_p99_us"] = Percentile(trips_us, 0.99);
}

// What a query with a prior asks when all is cached.
void PostgresWarmQuery(benchmark::State& state) {
  const MapStore store = MapStore::Open(ServerMapOfTiles(1000), OpenMode::kServing);
  const GeoBox box = BoxAround(Geodetic::FromDegrees(49.005, 7.01, 0.0), 150.0);
  for (auto _ : state) {
    const MapSnapshot snapshot = store.Snapshot();
    benchmark::DoNotOptimize(snapshot.CurrentCodebook());
    benchmark::DoNotOptimize(snapshot.FindTiles(box));
  }
}

// A payload whose size in MiB is the argument.
void PostgresPayload(benchmark::State& state) {
  const std::string url = PostgresCluster::Shared().CreateDatabase(
      fmt::format("payload{}_{}", state.range(0), Clock::now().time_since_epoch().count()));
  MapStore store = MapStore::Create(url);
  std::vector<uint8_t> payload(static_cast<size_t>(state.range(0)) << 20);
  std::mt19937 random(1);
  std::generate(payload.begin(), payload.end(), std::ref(random));
  MapUpdate update = store.BeginUpdate();
  update.AddCodebook(testing::RandomCodebook());
  const PayloadId id = update.PutTile(testing::RecordOf(testing::RandomTile()), payload);
  update.Publish();
  for (auto _ : state) {
    benchmark::DoNotOptimize(store.Snapshot().LoadPayload(id));
  }
}

BENCHMARK(PostgresFindTiles)->Arg(100'000)->Arg(1'000'000)->Iterations(1)->UseRealTime();
BENCHMARK(PostgresWarmQuery)->Unit(benchmark::kMicrosecond);
BENCHMARK(PostgresPayload)->Arg(6)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace cairn
