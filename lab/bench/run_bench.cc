#include "lab/bench/run_bench.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/large_vector.h"
#include "core/require.h"
#include "core/seconds_since.h"
#include "core/statistics.h"
#include "engine/index/byte_descriptors.h"
#include "engine/localizer.h"
#include "engine/tiles/searchable_tile.h"
#include "lab/bench/thread_cpu_clock.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/codebook/distance_statistics.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

constexpr size_t kMedianQuantile = 9;  // Codebook quantiles are 0.05, 0.10, ...
constexpr double kThresholdQuantile = 0.9;

class Stopwatch {
 public:
  double Seconds() const { return SecondsSince(start_); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Excludes time that a shared machine gives to others. Use for work of this thread alone that does
// not wait.
class ProcessorStopwatch {
 public:
  double Seconds() const { return ThreadCpuSeconds() - start_; }

 private:
  double start_ = ThreadCpuSeconds();
};

// Binds the thread and the threads that it starts to the current core, until destroyed.
class OneCore {
 public:
  OneCore() {
    is_bound_ = sched_getaffinity(0, sizeof(previous_), &previous_) == 0;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(std::max(0, sched_getcpu()), &one);
    is_bound_ = is_bound_ && sched_setaffinity(0, sizeof(one), &one) == 0;
  }
  ~OneCore() {
    if (is_bound_) {
      sched_setaffinity(0, sizeof(previous_), &previous_);
    }
  }
  OneCore(const OneCore&) = delete;
  OneCore& operator=(const OneCore&) = delete;

 private:
  cpu_set_t previous_;
  bool is_bound_ = false;
};

// Measures a query with an empty cache, which loads every tile.
void MeasureColdQuery(const std::shared_ptr<const MapStore>& store, const EvalQuery& query,
                      const RunBenchOptions& options, BenchFigures* figures) {
  const LocalizeResult result =
      Localizer(store, options.localizer, options.cache_bytes).Localize(query.query);
  figures->cold_tile_seconds =
      result.times.seconds[static_cast<int>(Stage::kTiles)] /
      static_cast<double>(std::max<int64_t>(1, result.counters.num_tiles_loaded));
  figures->cold_query_seconds = result.times.total_seconds;
}

// An unnamed file that holds a payload.
class PayloadFile {
 public:
  explicit PayloadFile(std::span<const uint8_t> payload) : file_(std::tmpfile()) {
    Check(file_ != nullptr);
    Check(std::fwrite(payload.data(), 1, payload.size(), file_) == payload.size());
    Check(std::fflush(file_) == 0);
  }
  ~PayloadFile() { std::fclose(file_); }
  PayloadFile(const PayloadFile&) = delete;
  PayloadFile& operator=(const PayloadFile&) = delete;

  // Reads the whole payload with one call.
  void Read(std::span<uint8_t> payload) const {
    Check(pread(fileno(file_), payload.data(), payload.size(), 0) ==
          static_cast<ssize_t>(payload.size()));
  }

 private:
  static void Check(bool is_good) {
    if (!is_good) {
      throw Error(ErrorCode::kIo, std::string("scratch file: ") + std::strerror(errno));
    }
  }

  std::FILE* file_;
};

// Alternates loads and plain reads. As in a full cache, each tile is dropped when the next has been
// loaded.
void MeasureTileLoads(const MapSnapshot& snapshot, const IndexOptions& options,
                      BenchFigures* figures) {
  constexpr int kNumRounds = 15;
  const std::vector<TileRecord> records = snapshot.AllTiles(std::numeric_limits<int64_t>::max());
  const std::shared_ptr<const Codebook> codebook = snapshot.CurrentCodebook();
  std::vector<std::unique_ptr<const PayloadFile>> files;
  std::vector<LargeVector<uint8_t>> payloads;
  for (const TileRecord& record : records) {
    payloads.push_back(snapshot.LoadPayload(record.payload_id));
    files.push_back(std::make_unique<const PayloadFile>(payloads.back()));
  }
  std::vector<std::shared_ptr<const SearchableTile>> tiles(records.size());
  std::vector<double> load_seconds, blob_seconds, read_seconds;
  for (int round = 0; round < kNumRounds; ++round) {
    for (size_t i = 0; i < records.size(); ++i) {
      const ProcessorStopwatch load;
      LargeVector<uint8_t> blob = snapshot.LoadPayload(records[i].payload_id);
      const ProcessorStopwatch from_blob;
      const auto gone =
          std::exchange(tiles[i], MakeSearchableTile(std::move(blob), codebook, options));
      blob_seconds.push_back(from_blob.Seconds());
      load_seconds.push_back(load.Seconds());
    }
    for (size_t i = 0; i < records.size(); ++i) {
      const ProcessorStopwatch stopwatch;
      files[i]->Read(payloads[i]);
      read_seconds.push_back(stopwatch.Seconds());
    }
  }
  figures->tile_load_seconds = Median(load_seconds);
  figures->blob_load_seconds = Median(blob_seconds);
  figures->plain_read_seconds = Median(read_seconds);
}

// Takes the median of three runs over all tiles. A single run may take half as long again as
// another.
void MeasureExhaustiveSearch(const MapSnapshot& snapshot, const EvalQuery& query,
                             BenchFigures* figures) {
  const std::shared_ptr<const Codebook> codebook = snapshot.CurrentCodebook();
  if (!codebook) {
    throw Error(ErrorCode::kBadInput, "the map is empty");
  }
  figures->same_landmark_distance = SameLandmarkDistance(*codebook, 0.5);
  figures->other_landmark_distance = codebook->other_landmark_distance_quantiles[kMedianQuantile];
  const double max_distance = SameLandmarkDistance(*codebook, kThresholdQuantile);
  const DescriptorMatrix queries = DescriptorCodec(codebook).ProjectFeatures(query.query.features);
  std::array<double, 3> seconds{};
  for (const TileRecord& record : snapshot.AllTiles(std::numeric_limits<int64_t>::max())) {
    const ByteDescriptors descriptors(*codebook,
                                      DecodeTile(snapshot.LoadPayload(record.payload_id)).codes);
    for (double& repeat : seconds) {
      std::vector<DescriptorHit> hits;
      const Stopwatch stopwatch;
      descriptors.RangeSearch(queries, max_distance, &hits);
      repeat += stopwatch.Seconds();
    }
  }
  std::sort(seconds.begin(), seconds.end());
  figures->exhaustive_seconds = seconds[1];
}

}  // namespace

void RunBenchOptions::Validate() const {
  RequireOption(num_repeats >= 1, "num_repeats must be at least 1");
  RequireOption(max_position_error_m > 0.0 && max_rotation_error_rad > 0.0,
                "the largest errors of a right answer must be positive");
  localizer.Validate();
}

BenchFigures RunBench(std::shared_ptr<const MapStore> store, const std::vector<EvalQuery>& queries,
                      const RunBenchOptions& options) {
  options.Validate();
  if (queries.empty()) {
    throw Error(ErrorCode::kInvalidArgument, "the benchmark needs at least one query");
  }
  const OneCore one_core;
  BenchFigures figures;
  {
    const MapSnapshot snapshot = store->Snapshot();
    const MapInfo info = snapshot.Info();
    figures.num_tiles = info.num_tiles;
    figures.num_descriptors = info.num_descriptors;
    figures.payload_bytes_per_tile = static_cast<double>(info.payload_bytes) /
                                     static_cast<double>(std::max<int64_t>(1, info.num_tiles));
    MeasureExhaustiveSearch(snapshot, queries.front(), &figures);
    MeasureTileLoads(snapshot, options.localizer.matching.index, &figures);
  }
  MeasureColdQuery(store, queries.front(), options, &figures);

  const Localizer localizer(std::move(store), options.localizer, options.cache_bytes);
  for (const EvalQuery& query : queries) {  // Fills the cache.
    localizer.Localize(query.query);
  }
  const CacheStats stats = localizer.cache()->Stats();
  figures.cached_bytes_per_tile = static_cast<double>(stats.bytes) /
                                  static_cast<double>(std::max<size_t>(1, stats.num_entries));
  std::vector<EvalQuery> repeated;
  for (int i = 0; i < options.num_repeats; ++i) {
    repeated.insert(repeated.end(), queries.begin(), queries.end());
  }
  figures.warm = Evaluate(
      repeated, [&](const EvalQuery& query) { return localizer.Localize(query.query); }, {});
  figures.num_right = static_cast<int>(std::count_if(
      figures.warm.answers.begin(), figures.warm.answers.end(), [&](const EvalAnswer& answer) {
        return answer.position_error_m <= options.max_position_error_m &&
               answer.rotation_error_rad <= options.max_rotation_error_rad;
      }));
  return figures;
}

}  // namespace cairn
