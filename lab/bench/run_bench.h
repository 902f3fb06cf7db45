// Measures a query against a map, stage by stage, on one core.
#ifndef CAIRN_LAB_BENCH_RUN_BENCH_H_
#define CAIRN_LAB_BENCH_RUN_BENCH_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/localizer_options.h"
#include "eval/eval_query.h"
#include "eval/evaluation.h"
#include "storage/map/map_store.h"

namespace cairn {

struct RunBenchOptions {
  int num_repeats = 3;  // Of every query, warm.
  // A right answer is this near to the true pose. Metres, radians.
  double max_position_error_m = 0.5;
  double max_rotation_error_rad = 0.02;
  size_t cache_bytes = size_t{4} << 30;
  LocalizerOptions localizer;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

struct BenchFigures {
  EvalReport warm;    // All tiles in the cache before the first query.
  int num_right = 0;  // Of warm.answers.
  // Until a tile can be searched; mean, file in the page cache. What is decoded only when a query
  // needs it is in the next.
  double cold_tile_seconds = 0;
  double cold_query_seconds = 0;  // The first query of all, with an empty cache.
  // From the map file in the page cache until a tile can be searched; the same from the blob in
  // memory, without SQLite, tile after tile as in a cache that is full; and to read the blob's
  // bytes of a plain file in the page cache into memory that has been used before. Processor time;
  // medians of many tiles.
  double tile_load_seconds = 0.0;
  double blob_load_seconds = 0.0;
  double plain_read_seconds = 0.0;
  int64_t num_tiles = 0;
  int64_t num_descriptors = 0;
  double payload_bytes_per_tile = 0.0;
  double cached_bytes_per_tile = 0.0;
  // All descriptors of the map against those of one query, one by one: what an index has to beat,
  // and a measure of the machine; the median of three times.
  double exhaustive_seconds = 0.0;
  // Median distances in projected space between two observations of a landmark, and to the nearest
  // of 10,000 other landmarks: how hard the descriptors are to tell apart.
  double same_landmark_distance = 0.0;
  double other_landmark_distance = 0.0;
};

// Runs everything in the calling thread, bound to one core meanwhile. Every query must touch every
// tile of the map, or the figures mean little. Throws as Localizer::Localize.
BenchFigures RunBench(std::shared_ptr<const MapStore> store, const std::vector<EvalQuery>& queries,
                      const RunBenchOptions& options);

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_RUN_BENCH_H_
