// Puts tiles into the cache before anything is timed. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_WARM_TILES_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_WARM_TILES_H_

#include <memory>
#include <vector>

#include "engine/localizer_options.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "engine/tiles/tile_cache.h"
#include "lab/experiments/experiment_world.h"

namespace cairn {

// Makes caches that hold the tiles of all queries of one world, with the given index options. Keeps
// the last cache, so that successive variants with the same index share it. Use from one thread.
class WarmTiles {
 public:
  // `world` must outlive the object. Indexes tiles on `num_threads` threads.
  WarmTiles(const ExperimentWorld& world, int num_threads)
      : world_(world), num_threads_(num_threads) {}

  std::shared_ptr<TileCache> For(const LocalizerOptions& options);

 private:
  const ExperimentWorld& world_;
  int num_threads_;
  std::shared_ptr<TileCache> last_;
};

// A query that is ready for the matching stage.
struct PreparedQuery {
  QueryContext context;
  std::vector<TileView> tiles;
};
PreparedQuery PrepareQuery(const ExperimentWorld& world, const LocalizerOptions& options,
                           const EvalQuery& query, TileCache* cache);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_WARM_TILES_H_
