#include "lab/experiments/measure/warm_tiles.h"

#include <fmt/format.h>

#include <cstddef>
#include <memory>
#include <utility>

#include "core/parallel_for.h"
#include "engine/query/build_query_context.h"
#include "engine/query/localize_result.h"
#include "engine/tiles/fetch_tiles.h"
#include "engine/tiles/search_region.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr size_t kCacheBytes = size_t{8} << 30;  // Larger than the tiles of any experiment.

// Equal keys mean equal indices.
std::string IndexKey(const IndexOptions& index) {
  const RandomGridsOptions& grids = index.grids;
  const InvertedListsOptions& lists = index.lists;
  return fmt::format("{} w{} g{} {} {} {} {} {} l{} {} {} {} {}", static_cast<int>(index.kind),
                     index.num_reference_words, grids.num_grids, grids.num_hashed_dims,
                     grids.cell_width_sigmas, grids.num_probes, grids.max_candidates_per_cell,
                     grids.seed, lists.num_lists, lists.num_probes, lists.num_iterations,
                     lists.seed, index.other ? index.other->name() : "");
}

// A disc that holds the map, which must not be empty.
SearchRegion RegionOfMap(const MapInfo& info) {
  const GeoBox& bounds = *info.bounds;
  const Geodetic middle = {0.5 * (bounds.south_rad + bounds.north_rad),
                           0.5 * (bounds.west_rad + bounds.east_rad), 0.0};
  const double radius_m = GroundDistanceM(middle, {bounds.south_rad, bounds.west_rad, 0.0});
  return RegionOfPlace(middle, radius_m, info.num_tiles);
}

}  // namespace

PreparedQuery PrepareQuery(const ExperimentWorld& world, const LocalizerOptions& options,
                           const EvalQuery& query, TileCache* cache) {
  const MapSnapshot snapshot = world.store->Snapshot();
  const SearchRegion region = query.query.prior ? RegionOfPrior(*query.query.prior, options.prior)
                                                : RegionOfMap(world.info);
  PreparedQuery prepared;
  prepared.context =
      BuildQueryContext(query.query, DescriptorCodec(snapshot.CurrentCodebook()), region);
  StageCounters counters;
  prepared.tiles = FetchTiles(snapshot, cache, options.tiles, options.matching.index,
                              &prepared.context.region, &counters);
  return prepared;
}

std::shared_ptr<TileCache> WarmTiles::For(const LocalizerOptions& options) {
  const std::string key = IndexKey(options.matching.index);
  if (last_ == nullptr || key != key_) {
    last_.reset();  // Free it first: two caches may not fit into memory.
    auto cache = std::make_shared<TileCache>(kCacheBytes);
    ParallelFor(static_cast<int>(world_.queries.size()), num_threads_,
                [&](int i) { PrepareQuery(world_, options, world_.queries[i], cache.get()); });
    last_ = std::move(cache);
    key_ = key;
  }
  return last_;
}

}  // namespace cairn
