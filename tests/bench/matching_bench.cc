// Benchmarks of the stages `tiles` and `matching` on one tile of the paper's size: 250,000
// landmarks with 2 descriptors each (the paper: 200,000 with 2.5 on average).
//
//   ColdLoad        decodes a tile's bytes and builds its index, as after a cache miss
//   BuildIndex      builds the index alone; `to_sort` is its time over that of std::sort on the
//                   same pairs of bucket and descriptor, one sort per grid
//   SearchGrids     finds descriptors near 1,000 keypoints with random grids; arguments: grids,
//                   hashed dimensions, cell width in tenths of a sigma, probes
//   SearchKind      the same search with the other kinds of index; arguments: kind, probes
//   SearchAll       the same search by comparison with every descriptor
//   ScanDistances   the inner loop of SearchAll; argument: variant of the processor
//   ScanBlocks      the inner loop of inverted lists; argument: variant of the processor
//   MatchFeatures   the whole stage against one tile
//
// Counters: time_per_query, distances_per_query, recall (the true landmark is among the 4 nearest
// hits), relative_recall (compared with exhaustive search), megabytes. If recall collapses, the
// benchmark reports an error.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "engine/index/blocked_rows.h"
#include "engine/index/cell_hasher.h"
#include "engine/index/distance_kernels.h"
#include "engine/index/hash_buckets.h"
#include "engine/index/random_grids.h"
#include "engine/matching/match_features.h"
#include "engine/synthetic_descriptors.h"
#include "engine/tiles/searchable_tile.h"
#include "lab/rivals/index_methods.h"
#include "storage/codebook/distance_statistics.h"
#include "storage/tile/tile_codec.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr int kNumLandmarks = 250'000;
constexpr int kDescriptorsPerLandmark = 2;
constexpr int kNumDescriptors = kNumLandmarks * kDescriptorsPerLandmark;
constexpr int kNumQueries = 1'000;
constexpr int kMaxNeighbors = 4;
constexpr double kThresholdQuantile = 0.9;
constexpr double kMinRelativeRecall = 0.8;

const testing::SyntheticDescriptors& Data() {
  static const testing::SyntheticDescriptors data =
      testing::MakeSyntheticDescriptors({.num_landmarks = kNumLandmarks,
                                         .descriptors_per_landmark = kDescriptorsPerLandmark,
                                         .num_queries = kNumQueries});
  return data;
}

double Threshold() { return SameLandmarkDistance(*Data().codebook, kThresholdQuantile); }

double ExhaustiveRecall() {
  static const double recall = [] {
    std::vector<DescriptorHit> hits;
    ByteDescriptors(*Data().codebook, Data().codes).RangeSearch(Data().queries, Threshold(), &hits);
    return testing::LandmarkRecall(Data(), hits, kMaxNeighbors);
  }();
  return recall;
}

// A tile that holds the data.
const Tile& BenchTile() {
  static const Tile tile = [] {
    Tile result = testing::RandomTile({.num_landmarks = kNumLandmarks,
                                       .max_descriptors_per_landmark = 1,
                                       .num_keyframes = 500,
                                       .num_landmarks_per_keyframe = 1'000});
    for (uint32_t& begin : result.descriptor_begin) {
      begin *= kDescriptorsPerLandmark;
    }
    for (std::vector<uint8_t>* attribute :
         {&result.orientation_codes, &result.size_codes, &result.azimuth_codes}) {
      attribute->resize(kNumDescriptors, 1);
    }
    result.codes = Data().codes;
    return result;
  }();
  return tile;
}

void SetQueryCounters(benchmark::State& state, int64_t num_distances) {
  using benchmark::Counter;
  const double num_queries = static_cast<double>(kNumQueries);
  state.counters["time_per_query"] =
      Counter(num_queries, Counter::kIsIterationInvariantRate | Counter::kInvert);
  state.counters["distances_per_query"] = static_cast<double>(num_distances) / num_queries;
}

void CheckRecall(benchmark::State& state, const std::vector<DescriptorHit>& hits) {
  const double recall = testing::LandmarkRecall(Data(), hits, kMaxNeighbors);
  state.counters["recall"] = recall;
  state.counters["relative_recall"] = recall / ExhaustiveRecall();
  if (recall < kMinRelativeRecall * ExhaustiveRecall()) {
    state.SkipWithError("recall collapsed");
  }
}

void ColdLoad(benchmark::State& state) {
  const std::vector<uint8_t> blob = EncodeTile(BenchTile());
  size_t num_bytes = 0;
  for (auto _ : state) {
    const SearchableTile tile(DecodeTile(blob), Data().codebook, IndexOptions());
    num_bytes = tile.MemoryBytes();
  }
  state.counters["megabytes"] = static_cast<double>(num_bytes) * 1e-6;
  state.counters["stored_megabytes"] = static_cast<double>(blob.size()) * 1e-6;
}
BENCHMARK(ColdLoad)->Unit(benchmark::kMillisecond);

double CpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void BuildIndex(benchmark::State& state) {
  constexpr int kNumBucketBits = 18;
  const RandomGridsOptions options;
  const CellHasher hasher(*Data().codebook, options);
  std::vector<std::vector<std::pair<uint32_t, uint32_t>>> pairs(options.num_grids);
  for (int grid = 0; grid < options.num_grids; ++grid) {
    for (const uint32_t hash : hasher.HashCodes(*Data().codebook, Data().codes, grid)) {
      pairs[grid].emplace_back(BucketOf(hash, kNumBucketBits), pairs[grid].size());
    }
  }
  double build_seconds = 0.0, sort_seconds = 0.0;
  size_t num_bytes = 0;
  for (auto _ : state) {
    const double start = CpuSeconds();
    const RandomGrids grids(*Data().codebook, Data().codes, options);
    build_seconds += CpuSeconds() - start;
    num_bytes = grids.MemoryBytes();
    state.PauseTiming();
    for (std::vector<std::pair<uint32_t, uint32_t>> unsorted : pairs) {
      const double sort_start = CpuSeconds();
      std::sort(unsorted.begin(), unsorted.end());
      sort_seconds += CpuSeconds() - sort_start;
      benchmark::DoNotOptimize(unsorted.data());
    }
    state.ResumeTiming();
  }
  state.counters["to_sort"] = build_seconds / sort_seconds;
  state.counters["megabytes"] = static_cast<double>(num_bytes) * 1e-6;
}
BENCHMARK(BuildIndex)->Unit(benchmark::kMillisecond);

void SearchGrids(benchmark::State& state) {
  RandomGridsOptions options;
  options.num_grids = static_cast<int>(state.range(0));
  options.num_hashed_dims = static_cast<int>(state.range(1));
  options.cell_width_sigmas = 0.1 * static_cast<double>(state.range(2));
  options.num_probes = static_cast<int>(state.range(3));
  const RandomGrids grids(*Data().codebook, Data().codes, options);
  std::vector<DescriptorHit> hits;
  int64_t num_distances = 0;
  for (auto _ : state) {
    hits.clear();
    num_distances = grids.RangeSearch(Data().queries, Threshold(), &hits);
  }
  SetQueryCounters(state, num_distances);
  CheckRecall(state, hits);
  state.counters["megabytes"] = static_cast<double>(grids.MemoryBytes()) * 1e-6;
}
BENCHMARK(SearchGrids)
    ->Args({2, 10, 60, 12})  // The default.
    ->Args({2, 10, 60, 28})
    ->Args({2, 11, 60, 12})
    ->Args({3, 10, 50, 22})
    ->Args({2, 10, 70, 12})
    ->Args({2, 9, 60, 12})
    ->Args({1, 9, 70, 24})
    ->Unit(benchmark::kMillisecond);

void SearchKind(benchmark::State& state) {
  const auto method = static_cast<IndexMethod>(state.range(0));
  IndexMethodOptions options;
  options.lists.num_probes = static_cast<int>(state.range(1));
  options.multi_index.num_probes = static_cast<int>(state.range(1));
  options.kd_tree.num_probes = static_cast<int>(state.range(1));
  state.SetLabel(IndexMethodName(method));
  const auto index =
      MakeMatchingIndex(*Data().codebook, Data().codes, MakeIndexOptions(method, options));
  std::vector<DescriptorHit> hits;
  int64_t num_distances = 0;
  for (auto _ : state) {
    hits.clear();
    num_distances = index->RangeSearch(Data().queries, Threshold(), &hits);
  }
  SetQueryCounters(state, num_distances);
  CheckRecall(state, hits);
  state.counters["megabytes"] = static_cast<double>(index->MemoryBytes()) * 1e-6;
}
BENCHMARK(SearchKind)
    ->Args({static_cast<int64_t>(IndexMethod::kInvertedLists), 12})  // The default.
    ->Args({static_cast<int64_t>(IndexMethod::kInvertedLists), 32})
    ->Args({static_cast<int64_t>(IndexMethod::kInvertedMultiIndex), 1000})
    ->Args({static_cast<int64_t>(IndexMethod::kKdTree), 128})
    ->Unit(benchmark::kMillisecond);

void SearchAll(benchmark::State& state) {
  const ByteDescriptors descriptors(*Data().codebook, Data().codes);
  std::vector<DescriptorHit> hits;
  for (auto _ : state) {
    hits.clear();
    descriptors.RangeSearch(Data().queries, Threshold(), &hits);
  }
  SetQueryCounters(state, int64_t{kNumDescriptors} * kNumQueries);
  CheckRecall(state, hits);
  state.counters["megabytes"] = static_cast<double>(descriptors.MemoryBytes()) * 1e-6;
}
BENCHMARK(SearchAll)->Unit(benchmark::kMillisecond);

// Compares the distances to the first rows with those of the portable kernel, and counts them.
void CheckDistances(benchmark::State& state, const ByteDescriptors& descriptors,
                    const std::vector<int16_t>& query, const std::vector<int32_t>& sq_distances) {
  std::vector<int32_t> expected(sq_distances.size());
  SupportedDistanceKernels().front()->scan(query.data(), descriptors.rows(),
                                           descriptors.scale().stride(), expected.size(),
                                           expected.data());
  if (sq_distances != expected) {
    state.SkipWithError("variants disagree");
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * expected.size()));
}

void ScanDistances(benchmark::State& state) {
  constexpr size_t kNumRows = 1'024;
  const DistanceKernels& kernels = *SupportedDistanceKernels()[state.range(0)];
  state.SetLabel(kernels.name);
  const ByteDescriptors descriptors(*Data().codebook, Data().codes);
  const ByteScale& scale = descriptors.scale();
  const std::vector<int16_t> query = scale.QuantizeQueries(Data().queries.topRows(1));
  std::vector<int32_t> sq_distances(kNumRows);
  for (auto _ : state) {
    kernels.scan(query.data(), descriptors.rows(), scale.stride(), kNumRows, sq_distances.data());
    benchmark::DoNotOptimize(sq_distances.data());
    benchmark::ClobberMemory();
  }
  CheckDistances(state, descriptors, query, sq_distances);
}
BENCHMARK(ScanDistances)
    ->DenseRange(0, static_cast<int64_t>(SupportedDistanceKernels().size()) - 1);

void ScanBlocks(benchmark::State& state) {
  constexpr uint32_t kNumRows = 1'024;
  const BlockKernels& kernels = *SupportedBlockKernels()[state.range(0)];
  state.SetLabel(kernels.name);
  const ByteDescriptors descriptors(*Data().codebook, Data().codes);
  const ByteScale& scale = descriptors.scale();
  std::vector<uint32_t> order(kNumRows);
  std::iota(order.begin(), order.end(), 0u);
  const BlockedRows rows(descriptors.rows(), scale.stride(), order);
  const std::vector<int16_t> query = scale.QuantizeQueries(Data().queries.topRows(1));
  const BlockQueries queries(query, rows.centers());
  std::vector<int32_t> sq_distances(kNumRows);
  for (auto _ : state) {
    rows.ScanWith(kernels, queries[0], sq_distances.data());
    benchmark::DoNotOptimize(sq_distances.data());
    benchmark::ClobberMemory();
  }
  CheckDistances(state, descriptors, query, sq_distances);
}
BENCHMARK(ScanBlocks)->DenseRange(0, static_cast<int64_t>(SupportedBlockKernels().size()) - 1);

void MatchFeaturesStage(benchmark::State& state) {
  QueryContext query;
  query.descriptors = Data().queries;
  query.keypoints.resize(kNumQueries);
  query.rays_in_cam.resize(kNumQueries, Eigen::Vector3d::UnitZ());
  query.gravity_orientations_rad.resize(kNumQueries);
  const std::vector<TileView> tiles = {
      {std::make_shared<const SearchableTile>(BenchTile(), Data().codebook, IndexOptions()),
       Rigid3d()}};
  MatchingOptions options;
  options.distance_quantile = kThresholdQuantile;
  FeatureMatches matches;
  for (auto _ : state) {
    matches = MatchFeatures(query, tiles, options);
  }
  SetQueryCounters(state, matches.num_distances);
  int num_recalled = 0;
  for (const Correspondence& match : matches.correspondences) {
    num_recalled +=
        static_cast<int>(match.landmark_idx) == Data().true_landmarks[match.keypoint_idx] ? 1 : 0;
  }
  // Every second query shows a landmark.
  state.counters["recall"] = static_cast<double>(num_recalled) / (kNumQueries / 2);
  if (num_recalled < kMinRelativeRecall * ExhaustiveRecall() * kNumQueries / 2) {
    state.SkipWithError("recall collapsed");
  }
}
BENCHMARK(MatchFeaturesStage)->Name("MatchFeatures")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cairn
