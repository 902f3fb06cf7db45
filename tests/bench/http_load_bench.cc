// Measures a running server with 1, 8 and 64 clients at once, each of which sends one query after
// another: requests per second and percentiles of the latency at the client. Queries have 1,000 raw
// features; the map has four warm tiles with 50,000 landmarks each. Every answer is compared with
// the truth (`right`). Clients and server share the machine; `client_cpu` is the clients' share of
// the processor time.
//
// If `deadline_ms` is above 0, every query has that timeout. `answered` is then the share of
// answers with a pose, and the latency should stay near the deadline.
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "http/client.h"
#include "http/server.h"
#include "lab/bench/bench_world.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using Clock = std::chrono::steady_clock;

double CpuSeconds(clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// A map, queries against it and a server that has its tiles in the cache.
class LoadedServer {
 public:
  LoadedServer() {
    BenchWorldOptions world;
    world.landmarks_per_tile = 50'000;
    world.keyframes_per_tile = 250;
    queries_ = BuildBenchWorld(world, dir_.File("load.gpkg"), nullptr);
    ServerOptions options;
    options.map_path = dir_.File("load.gpkg");
    options.port = 0;
    options.cache_bytes = size_t{4} << 30;
    options.default_timeout_ms = 60'000;
    server_ = std::make_unique<Server>(options);
    server_->Start();
    LocalizeClient(client_options()).LocalizeFeatures(queries_.front().query);  // Loads the tiles.
  }

  ClientOptions client_options() const {
    return {.url = "http://127.0.0.1:" + std::to_string(server_->port()), .timeout_ms = 60'000};
  }
  const std::vector<EvalQuery>& queries() const { return queries_; }

 private:
  testing::TempDir dir_;
  std::vector<EvalQuery> queries_;
  std::unique_ptr<Server> server_;
};

LoadedServer& SharedServer() {
  static LoadedServer server;
  return server;
}

struct Tally {
  std::vector<double> latency_s;
  int num_localized = 0;
  int num_right = 0;
  double cpu_s = 0.0;
};

bool IsRight(const LocalizeResult& result, const EvalQuery& query) {
  constexpr double kMaxErrorM = 0.5;
  constexpr double kMaxErrorRad = 0.02;
  return (result.cam_from_ecef.Inverse().translation - query.cam_from_ecef.Inverse().translation)
                 .norm() < kMaxErrorM &&
         RotationAngleRad(result.cam_from_ecef.rotation, query.cam_from_ecef.rotation) <
             kMaxErrorRad;
}

// Sends queries until all clients together have sent `num_requests`.
void RunClient(const LoadedServer& server, int deadline_ms, int num_requests,
               std::atomic<int>* next, Tally* tally) {
  LocalizeClient client(server.client_options());
  for (int i = (*next)++; i < num_requests; i = (*next)++) {
    EvalQuery query = server.queries()[i % server.queries().size()];
    const Clock::time_point start = Clock::now();
    if (deadline_ms > 0) {
      query.query.deadline = start + std::chrono::milliseconds(deadline_ms);
    }
    const LocalizeResult result = client.LocalizeFeatures(query.query);
    tally->latency_s.push_back(std::chrono::duration<double>(Clock::now() - start).count());
    tally->num_localized += result.localized;
    tally->num_right += result.localized && IsRight(result, query);
  }
  tally->cpu_s = CpuSeconds(CLOCK_THREAD_CPUTIME_ID);
}

double Percentile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

void ServerUnderLoad(benchmark::State& state) {
  const int num_clients = static_cast<int>(state.range(0));
  const int deadline_ms = static_cast<int>(state.range(1));
  const int num_requests = std::max(100, 5 * num_clients);
  LoadedServer& server = SharedServer();
  std::vector<Tally> tallies(num_clients);
  const double cpu_start = CpuSeconds(CLOCK_PROCESS_CPUTIME_ID);
  for (auto _ : state) {
    std::atomic<int> next{0};
    std::vector<std::thread> clients;
    for (Tally& tally : tallies) {
      clients.emplace_back([&] { RunClient(server, deadline_ms, num_requests, &next, &tally); });
    }
    for (std::thread& client : clients) {
      client.join();
    }
  }
  const double cpu_s = CpuSeconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_start;
  Tally all;
  for (const Tally& tally : tallies) {
    all.latency_s.insert(all.latency_s.end(), tally.latency_s.begin(), tally.latency_s.end());
    all.num_localized += tally.num_localized;
    all.num_right += tally.num_right;
    all.cpu_s += tally.cpu_s;
  }
  std::sort(all.latency_s.begin(), all.latency_s.end());
  const auto count = static_cast<double>(all.latency_s.size());
  state.counters["per_s"] = benchmark::Counter(count, benchmark::Counter::kIsRate);
  state.counters["p50_ms"] = 1e3 * Percentile(all.latency_s, 0.5);
  state.counters["p90_ms"] = 1e3 * Percentile(all.latency_s, 0.9);
  state.counters["p99_ms"] = 1e3 * Percentile(all.latency_s, 0.99);
  state.counters["cpu_ms"] = 1e3 * cpu_s / count;
  state.counters["client_cpu"] = all.cpu_s / cpu_s;
  state.counters["answered"] = all.num_localized / count;
  state.counters["right"] = all.num_right / count;
  if (all.num_right < all.num_localized) {
    state.SkipWithError("an answer is wrong");
  }
}
BENCHMARK(ServerUnderLoad)
    ->ArgNames({"clients", "deadline_ms"})
    ->ArgsProduct({{1, 8, 64}, {0, 200}})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cairn
