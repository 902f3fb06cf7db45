// Measures queries against a map, stage by stage, on one core.
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
  int num_repeats = 3;  // Per query, with warm tiles.
  // Largest error of an answer that counts as right, in meters and radians.
  double max_position_error_m = 0.5;
  double max_rotation_error_rad = 0.02;
  size_t cache_bytes = size_t{4} << 30;
  LocalizerOptions localizer;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

struct BenchFigures {
  EvalReport warm;    // All tiles were in the cache before the first query.
  int num_right = 0;  // Right answers among warm.answers.
  // Mean time until a tile can be searched; the file is in the page cache. Parts that are decoded
  // only when a query needs them are not included, but are part of cold_query_seconds.
  double cold_tile_seconds = 0;
  double cold_query_seconds = 0;  // The very first query, with an empty cache.
  // Processor time per tile; medians of many tiles:
  // - tile_load_seconds: from the map file in the page cache until the tile can be searched;
  // - blob_load_seconds: the same from the blob in memory, without SQLite, one tile after another
  //   as in a full cache;
  // - plain_read_seconds: reading the blob's bytes from a plain file in the page cache into memory
  //   that was used before.
  double tile_load_seconds = 0.0;
  double blob_load_seconds = 0.0;
  double plain_read_seconds = 0.0;
  int64_t num_tiles = 0;
  int64_t num_descriptors = 0;
  double payload_bytes_per_tile = 0.0;
  double cached_bytes_per_tile = 0.0;
  // Time to compare all descriptors of the map with all descriptors of one query, one by one; the
  // median of three runs. An index must beat this time. It is also a measure of the machine.
  double exhaustive_seconds = 0.0;
  // Median distances in projected space: between two observations of a landmark, and from an
  // observation to the nearest of 10,000 other landmarks. They show how hard it is to tell the
  // descriptors apart.
  double same_landmark_distance = 0.0;
  double other_landmark_distance = 0.0;
};

// Runs everything in the calling thread, which is bound to one core for the duration. The figures
// are meaningful only if every query touches every tile of the map. Throws the errors of
// Localizer::Localize.
BenchFigures RunBench(std::shared_ptr<const MapStore> store, const std::vector<EvalQuery>& queries,
                      const RunBenchOptions& options);

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_RUN_BENCH_H_
