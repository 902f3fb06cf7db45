#include "engine/localizer.h"

#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/shared_workers.h"
#include "engine/answer/answer.h"
#include "engine/answer/refine_winner.h"
#include "engine/explain_miss.h"
#include "engine/place_answers.h"
#include "engine/places/place_catalog.h"
#include "engine/query/build_query_context.h"
#include "engine/query/query_budget.h"
#include "engine/search.h"
#include "engine/stage_runner.h"
#include "engine/tiles/fetch_tiles.h"
#include "engine/tiles/search_region.h"
#include "engine/tiles/tile_finisher.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/map/read_latest.h"

namespace cairn {

namespace {

using Reason = NotLocalizedReason;

LocalizeResult EmptyResult(const LocalizeQuery& query) {
  LocalizeResult result;
  result.counters.num_keypoints = query.num_features();
  result.counters.used_prior = query.prior.has_value();
  result.counters.used_gravity = query.down_in_cam.has_value();
  return result;
}

// Returns nothing if the map is empty.
std::optional<QueryContext> MakeContext(const LocalizeQuery& query, const MapSnapshot& snapshot,
                                        const SearchRegion& region) {
  const auto codebook = snapshot.CurrentCodebook();
  if (codebook == nullptr) {
    return std::nullopt;
  }
  return BuildQueryContext(query, DescriptorCodec(codebook), region);
}

std::vector<TileId> IdsOf(const std::vector<TileView>& tiles) {
  std::vector<TileId> ids;
  for (const TileView& view : tiles) {
    ids.push_back(view.tile->id());
  }
  return ids;
}

// Picks the winner, refines it in the context in which it was found, and fills the result.
void Conclude(const LocalizeQuery& query, const std::optional<QueryContext>& context,
              const Search& search, const QueryBudget& budget, const LocalizerOptions& options,
              LocalizeResult* result) {
  if (!search.hypotheses().empty()) {
    const auto refine = [&](const PoseHypothesis& winner) {
      return RefineWinner(search.ContextOf(winner, *context), query, search.tiles(),
                          search.hypotheses(), winner, options.pose,
                          options.refinement.good_evidence);
    };
    ConcludeAnswer(*context, search.tiles(), search.hypotheses().all(), options.answer, refine,
                   result);
  }
  // With more time, the stages might have found enough.
  const bool found_too_little =
      result->reason == Reason::kTooFewMatches || result->reason == Reason::kTooFewInliers;
  if (found_too_little && (budget.DeadlinePassed() || result->counters.is_cut_short())) {
    result->reason = Reason::kTimeout;
  }
}

}  // namespace

struct Localizer::Impl {
  std::shared_ptr<const MapStore> store;
  std::shared_ptr<TileCache> cache;
  LocalizerOptions options;
  SharedWorkers workers;
  TileFinisher finisher{store.get(), cache.get(), &options.tiles, &options.matching.index,
                        &workers};

  PlaceCatalog catalog{&options.places};

  // `pinned`: the version to read; null: the latest.
  LocalizeResult Localize(const LocalizeQuery& query, const MapSnapshot* pinned);
  // `pinned`: as above. `place`: the region to search; null: that of the query's prior.
  LocalizeResult LocalizeNear(const LocalizeQuery& query, const MapSnapshot* pinned,
                              const SearchRegion* place);
  // Searches the places of the map that look most like the photo.
  LocalizeResult LocalizeAnywhere(const LocalizeQuery& query, const MapSnapshot& snapshot);
  // Returns those places, best first.
  std::vector<RankedPlace> RankPlaces(const LocalizeQuery& query, const MapSnapshot& snapshot,
                                      const QueryBudget& budget, StageCounters* counters);
  // The stages that read the map, prior and tiles.
  void ReadVersion(const MapSnapshot& snapshot, const LocalizeQuery& query,
                   const SearchRegion* place, const QueryBudget& budget, StageRunner* stages,
                   Search* search, std::optional<QueryContext>* context, LocalizeResult* result);
};

void Localizer::Impl::ReadVersion(const MapSnapshot& snapshot, const LocalizeQuery& query,
                                  const SearchRegion* place, const QueryBudget& budget,
                                  StageRunner* stages, Search* search,
                                  std::optional<QueryContext>* context, LocalizeResult* result) {
  result->map_version = snapshot.version();
  result->map_is_stale = snapshot.is_stale();
  stages->Run(Stage::kPrior, [&] {
    *context = MakeContext(query, snapshot,
                           place != nullptr ? *place : RegionOfPrior(*query.prior, options.prior));
    const bool has_few = query.num_features() < options.pose.min_inliers;
    return !*context ? Reason::kNoCoverage : has_few ? Reason::kTooFewFeatures : Reason::kNone;
  });
  stages->Run(Stage::kTiles, [&] {
    search->set_tiles(FetchTiles(snapshot, cache.get(), options.tiles, options.matching.index,
                                 &(*context)->region, &result->counters,
                                 budget.StopAfter(options.tiles.deadline_share)));
    result->tiles = IdsOf(search->tiles());
    return search->tiles().empty() ? Reason::kNoCoverage : Reason::kNone;
  });
  if (result->reason == Reason::kNoCoverage) {
    result->reason_text = ExplainMiss(query, *result, options, &snapshot);
  }
}

LocalizeResult Localizer::Impl::LocalizeNear(const LocalizeQuery& query, const MapSnapshot* pinned,
                                             const SearchRegion* place) {
  const QueryBudget::Clock::time_point start = QueryBudget::Clock::now();
  const QueryBudget budget{&workers, query.deadline};
  LocalizeResult result = EmptyResult(query);
  Search search(options, budget, &result.counters);
  std::optional<QueryContext> context;
  StageRunner stages(budget, &result);
  if (pinned != nullptr) {
    ReadVersion(*pinned, query, place, budget, &stages, &search, &context, &result);
  } else {
    ReadLatest(*store, query.deadline, [&](const MapSnapshot& snapshot) {
      ReadVersion(snapshot, query, place, budget, &stages, &search, &context, &result);
    });
  }
  if (stages.is_running()) {
    search.Run(query, &stages, &*context);
  }
  Conclude(query, context, search, budget, options, &result);
  if (!result.localized && result.reason_text.empty()) {
    result.reason_text = ExplainMiss(query, result, options, nullptr);
  }
  if (result.counters.tiles_cut_short) {
    finisher.Add(context->region);
  }
  result.times.total_seconds = SecondsSince(start);
  return result;
}

std::vector<RankedPlace> Localizer::Impl::RankPlaces(const LocalizeQuery& query,
                                                     const MapSnapshot& snapshot,
                                                     const QueryBudget& budget,
                                                     StageCounters* counters) {
  const StopFunction should_stop = budget.StopAfter(options.tiles.deadline_share);
  const CataloguedPlaces places = catalog.IndexOf(snapshot, should_stop);
  const std::optional<QueryContext> context = MakeContext(query, snapshot, {});
  std::vector<RankedPlace> ranked;
  if (places.index != nullptr && context) {
    ranked = places.index->Rank(*context, options.places, should_stop);
  }
  counters->tiles_cut_short = !places.is_complete || (should_stop && should_stop());
  return ranked;
}

LocalizeResult Localizer::Impl::LocalizeAnywhere(const LocalizeQuery& query,
                                                 const MapSnapshot& snapshot) {
  const QueryBudget::Clock::time_point start = QueryBudget::Clock::now();
  const QueryBudget budget{&workers, query.deadline};
  LocalizeResult without_place = EmptyResult(query);
  without_place.map_version = snapshot.version();
  without_place.map_is_stale = snapshot.is_stale();
  const int64_t num_tiles = snapshot.Info().num_tiles;
  std::vector<RankedPlace> ranked;
  StageRunner(budget, &without_place).Run(Stage::kPrior, [&] {
    ranked = RankPlaces(query, snapshot, budget, &without_place.counters);
    const bool has_few = query.num_features() < options.pose.min_inliers;
    return num_tiles == 0   ? Reason::kNoCoverage
           : has_few        ? Reason::kTooFewFeatures
           : ranked.empty() ? Reason::kTooFewMatches
                            : Reason::kNone;
  });
  PlaceAnswers answers(&options);
  for (const RankedPlace& place : ranked) {
    if (answers.AreEnough(place.score)) {
      break;
    }
    const SearchRegion region = RegionOfPlace(place.center, options.places.radius_m, num_tiles);
    answers.Add(place.score, LocalizeNear(query, &snapshot, &region));
  }
  LocalizeResult result = answers.empty() ? without_place : answers.Best();
  result.counters.num_tiles_found = num_tiles;
  result.counters.tile_limit_hit = result.counters.num_tiles_searched < num_tiles;
  result.counters.tiles_cut_short |= without_place.counters.tiles_cut_short;
  const bool found_too_little =
      result.reason == Reason::kTooFewMatches || result.reason == Reason::kTooFewInliers;
  if (found_too_little && (budget.DeadlinePassed() || result.counters.is_cut_short())) {
    result.reason = Reason::kTimeout;
  }
  if (!result.localized) {
    result.reason_text = ExplainMiss(query, result, options, &snapshot);
  }
  const auto prior = static_cast<size_t>(Stage::kPrior);
  result.times.seconds[prior] += without_place.times.seconds[prior];
  result.times.total_seconds = SecondsSince(start);
  return result;
}

LocalizeResult Localizer::Impl::Localize(const LocalizeQuery& query, const MapSnapshot* pinned) {
  query.Validate();
  if (query.prior) {
    return LocalizeNear(query, pinned, nullptr);
  }
  return pinned != nullptr ? LocalizeAnywhere(query, *pinned)
                           : ReadLatest(*store, query.deadline, [&](const MapSnapshot& snapshot) {
                               return LocalizeAnywhere(query, snapshot);
                             });
}

Localizer Localizer::Open(const std::string& path_or_url, const LocalizerOptions& options,
                          size_t cache_bytes) {
  return {std::make_shared<const MapStore>(MapStore::Open(path_or_url, OpenMode::kReadOnly)),
          options, cache_bytes};
}

Localizer::Localizer(std::shared_ptr<const MapStore> map, const LocalizerOptions& options,
                     size_t cache_bytes)
    : Localizer(std::move(map), options, std::make_shared<TileCache>(cache_bytes)) {}

Localizer::Localizer(std::shared_ptr<const MapStore> map, const LocalizerOptions& options,
                     std::shared_ptr<TileCache> cache) {
  options.Validate();
  impl_.reset(
      new Impl{std::move(map), std::move(cache), options, SharedWorkers(options.num_threads)});
}

Localizer::Localizer(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

LocalizeResult Localizer::Localize(const LocalizeQuery& query) const {
  const SharedWorkers::Caller caller(&impl_->workers);
  return impl_->Localize(query, nullptr);
}

LocalizeResult Localizer::LocalizeIn(const MapSnapshot& map, const LocalizeQuery& query) const {
  const SharedWorkers::Caller caller(&impl_->workers);
  return impl_->Localize(query, &map);
}

const LocalizerOptions& Localizer::options() const { return impl_->options; }
const MapStore& Localizer::map() const { return *impl_->store; }
const std::shared_ptr<TileCache>& Localizer::cache() const { return impl_->cache; }

}  // namespace cairn
