#include "lab/experiments/measure/warm_tiles.h"

#include <cstddef>
#include <memory>
#include <utility>

#include "core/parallel_for.h"
#include "engine/query/build_query_context.h"
#include "engine/tiles/fetch_tiles.h"
#include "engine/tiles/search_region.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr size_t kCacheBytes = size_t{8} << 30;  // Larger than the tiles of any experiment.

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
  FetchedTiles fetched = FetchTiles(SnapshotTiles(snapshot), region, options.tiles, cache);
  return {
      BuildQueryContext(query.query, DescriptorCodec(snapshot.CurrentCodebook()), fetched.region),
      std::move(fetched.views)};
}

std::shared_ptr<TileCache> WarmTiles::For(const LocalizerOptions& options) {
  if (last_ == nullptr || !last_->IndexesAs(options.matching.index)) {
    last_.reset();  // Free it first: two caches may not fit into memory.
    auto cache = std::make_shared<TileCache>(kCacheBytes, options.matching.index);
    ParallelFor(static_cast<int>(world_.queries.size()), num_threads_,
                [&](int i) { PrepareQuery(world_, options, world_.queries[i], cache.get()); });
    last_ = std::move(cache);
  }
  return last_;
}

}  // namespace cairn
