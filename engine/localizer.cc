#include "engine/localizer.h"

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/camera_of_this_size.h"
#include "core/error.h"
#include "core/seconds_since.h"
#include "core/shared_workers.h"
#include "engine/answer/answer.h"
#include "engine/answer/refine_winner.h"
#include "engine/empty_result.h"
#include "engine/explain_miss.h"
#include "engine/place_answers.h"
#include "engine/places/place_catalog.h"
#include "engine/pose/focal_search.h"
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

// Returns nothing if the map is empty, so that `codebook` is null.
std::optional<QueryContext> MakeContext(const LocalizeQuery& query,
                                        const std::shared_ptr<const Codebook>& codebook,
                                        const SearchRegion& region) {
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

// A version of a map.
struct VersionToRead {
  const MapTiles& tiles;
  const MapSnapshot* snapshot = nullptr;  // Null if the tiles are not those of a map on disk.

  // Tiles without a map have one version.
  MapVersion version() const { return snapshot != nullptr ? snapshot->version() : MapVersion{}; }
  int64_t num_tiles() const {
    return snapshot != nullptr ? snapshot->Info().num_tiles
                               : std::ssize(tiles.FindTiles(WholeEarth()));
  }
};

// With more time, the stages might have found enough. `is_complete`: they left out nothing.
bool FoundTooLittleInTime(const LocalizeResult& result, bool is_complete,
                          const QueryBudget& budget) {
  const bool found_too_little =
      result.reason == Reason::kTooFewMatches || result.reason == Reason::kTooFewInliers;
  return found_too_little && (budget.DeadlinePassed() || !is_complete);
}

// What the search near one place found.
struct PlaceResult {
  LocalizeResult result;
  bool has_all_tiles = true;  // The deadline left out no tile and no part of an index.
};

// The places of a map that look most like a photo, best first.
struct RankedPlaces {
  std::vector<RankedPlace> places;
  bool is_complete = true;  // The deadline left out no place.
};

StageCounters WithTiles(StageCounters counters, const FetchedTiles& fetched) {
  counters.num_tiles_found = fetched.num_found;
  counters.num_tiles_searched = std::ssize(fetched.views);
  counters.num_tiles_loaded = fetched.num_loaded;
  counters.num_descriptors = fetched.num_descriptors;
  counters.tile_limit_hit = fetched.limit_hit;
  counters.tiles_cut_short = !fetched.is_complete;
  return counters;
}

void RequireIndexesAs(const LocalizerOptions& options, const TileCache& cache) {
  if (!cache.IndexesAs(options.matching.index)) {
    throw Error(ErrorCode::kInvalidArgument,
                "matching.index differs from that of the shared cache; use a cache of its own");
  }
}

// Picks the winner and refines it in the context in which it was found. Returns `result` with it.
LocalizeResult Conclude(const LocalizeQuery& query, const Search& search,
                        const LocalizerOptions& options, LocalizeResult result) {
  if (search.hypotheses().empty()) {
    return result;
  }
  const auto refine = [&](const PoseHypothesis& winner) {
    return RefineWinner(search.ContextOf(winner), query, search.tiles(), search.hypotheses(),
                        winner, options.pose, options.refinement.good_evidence);
  };
  return ConcludeAnswer(search.context(), search.tiles(), search.hypotheses().all(), options.answer,
                        refine, std::move(result));
}

// Localizes with the stated camera and, if its parameters look like those of another size of the
// picture, with the camera that they would be then. The answer with the higher score counts; that
// of the other camera says that the focal length disagrees.
LocalizeResult WithEitherCamera(
    const LocalizeQuery& query,
    const std::function<LocalizeResult(const LocalizeQuery&)>& localize) {
  LocalizeResult result = localize(query);
  const std::optional<Camera> camera =
      query.other_cameras.empty() ? CameraOfThisSize(query.camera) : std::nullopt;
  if (!camera) {
    return result;
  }
  LocalizeQuery scaled = query;
  scaled.camera = *camera;
  LocalizeResult other = localize(scaled);
  if (!other.localized || (result.localized && result.score >= other.score)) {
    return result;
  }
  if (!other.camera) {
    other.camera = {.camera = *camera,
                    .focal_sigma_px = kAssumedFocalLogSigma * camera->focal_px()};
  }
  other.camera->assumed_focal_px = query.camera.focal_px();
  other.camera->assumed_focal_sigma_px = kAssumedFocalLogSigma * query.camera.focal_px();
  other.camera->focal_disagrees = true;
  other.times.total_seconds += result.times.total_seconds;
  return other;
}

}  // namespace

struct Localizer::Impl {
  std::shared_ptr<const MapStore> store;  // Null if there are `tiles`.
  const MapTiles* tiles;
  std::shared_ptr<TileCache> cache;
  LocalizerOptions options;
  SharedWorkers workers;
  TileFinisher finisher{[this](const auto& read) { ReadLatestTiles(read); }, cache.get(),
                        &options.tiles, &workers};

  PlaceCatalog catalog{&options.places};

  void ReadLatestTiles(const std::function<void(const MapTiles&)>& read) const {
    if (tiles != nullptr) {
      read(*tiles);
    } else {
      read(SnapshotTiles(store->Snapshot()));
    }
  }
  // `pinned`: the version to read; null: the latest.
  LocalizeResult Localize(const LocalizeQuery& query, const MapSnapshot* pinned);
  LocalizeResult LocalizeIn(const LocalizeQuery& query, const VersionToRead& version);
  // `place`: the region to search; null: that of the query's prior.
  PlaceResult LocalizeNear(const LocalizeQuery& query, const VersionToRead& version,
                           const SearchRegion* place);
  // Searches the places of the map that look most like the photo.
  LocalizeResult LocalizeAnywhere(const LocalizeQuery& query, const VersionToRead& version);
  RankedPlaces RankPlaces(const LocalizeQuery& query, const VersionToRead& version,
                          const QueryBudget& budget);
};

PlaceResult Localizer::Impl::LocalizeNear(const LocalizeQuery& query, const VersionToRead& version,
                                          const SearchRegion* place) {
  const QueryBudget::Clock::time_point start = QueryBudget::Clock::now();
  const QueryBudget budget{&workers, query.deadline};
  LocalizeResult result = EmptyResult(query, version.snapshot);
  StageRunner stages(budget);
  std::optional<QueryContext> context;
  stages.Run(Stage::kPrior, [&] {
    context = MakeContext(query, version.tiles.CurrentCodebook(),
                          place != nullptr ? *place : RegionOfPrior(*query.prior, options.prior));
    const bool has_few = query.num_features() < options.pose.min_inliers;
    return !context ? Reason::kNoCoverage : has_few ? Reason::kTooFewFeatures : Reason::kNone;
  });
  FetchedTiles fetched;
  stages.Run(Stage::kTiles, [&] {
    fetched = FetchTiles(version.tiles, context->region, options.tiles, cache.get(),
                         budget.StopAfter(options.tiles.deadline_share));
    return fetched.views.empty() ? Reason::kNoCoverage : Reason::kNone;
  });
  result.tiles = IdsOf(fetched.views);
  result.counters = WithTiles(result.counters, fetched);
  bool is_complete = fetched.is_complete;
  if (!fetched.is_complete) {
    finisher.Add(fetched.region);
  }
  if (stages.is_running()) {
    Search search(options, budget, WithRegion(*std::move(context), fetched.region),
                  std::move(fetched.views));
    search.Run(query, &stages);
    is_complete &= search.is_complete();
    result.counters = search.AddTo(result.counters);
    result.reason = stages.reason();
    result = Conclude(query, search, options, std::move(result));
  } else {
    result.reason = stages.reason();
  }
  if (FoundTooLittleInTime(result, is_complete, budget)) {
    result.reason = Reason::kTimeout;
  }
  if (!result.localized) {
    result.reason_text = ExplainMiss(query, result, options, version.snapshot);
  }
  result.times = stages.times();
  result.times.total_seconds = SecondsSince(start);
  return {std::move(result), fetched.is_complete};
}

RankedPlaces Localizer::Impl::RankPlaces(const LocalizeQuery& query, const VersionToRead& version,
                                         const QueryBudget& budget) {
  const StopFunction should_stop = budget.StopAfter(options.tiles.deadline_share);
  const CataloguedPlaces places = catalog.IndexOf(version.tiles, version.version(), should_stop);
  const std::optional<QueryContext> context =
      MakeContext(query, version.tiles.CurrentCodebook(), {});
  RankedPlaces ranked;
  if (places.index != nullptr && context) {
    ranked.places = places.index->Rank(*context, options.places, should_stop);
  }
  ranked.is_complete = places.is_complete && !(should_stop && should_stop());
  return ranked;
}

LocalizeResult Localizer::Impl::LocalizeAnywhere(const LocalizeQuery& query,
                                                 const VersionToRead& version) {
  const QueryBudget::Clock::time_point start = QueryBudget::Clock::now();
  const QueryBudget budget{&workers, query.deadline};
  LocalizeResult without_place = EmptyResult(query, version.snapshot);
  const int64_t num_tiles = version.num_tiles();
  RankedPlaces ranked;
  StageRunner stages(budget);
  stages.Run(Stage::kPrior, [&] {
    ranked = RankPlaces(query, version, budget);
    const bool has_few = query.num_features() < options.pose.min_inliers;
    return num_tiles == 0          ? Reason::kNoCoverage
           : has_few               ? Reason::kTooFewFeatures
           : ranked.places.empty() ? Reason::kTooFewMatches
                                   : Reason::kNone;
  });
  without_place.reason = stages.reason();
  PlaceAnswers answers(&options);
  bool is_complete = ranked.is_complete;
  for (const RankedPlace& place : ranked.places) {
    if (answers.AreEnough(place.score)) {
      break;
    }
    const SearchRegion region = RegionOfPlace(place.center, options.places.radius_m, num_tiles);
    PlaceResult found = LocalizeNear(query, version, &region);
    is_complete &= found.has_all_tiles;
    answers.Add(place.score, std::move(found.result));
  }
  LocalizeResult result = answers.empty() ? without_place : answers.Best();
  result.counters.num_tiles_found = num_tiles;
  result.counters.tile_limit_hit = result.counters.num_tiles_searched < num_tiles;
  result.counters.tiles_cut_short |= !ranked.is_complete;
  if (FoundTooLittleInTime(result, is_complete, budget)) {
    result.reason = Reason::kTimeout;
  }
  if (!result.localized) {
    result.reason_text = ExplainMiss(query, result, options, version.snapshot);
  }
  const auto prior = static_cast<size_t>(Stage::kPrior);
  result.times.seconds[prior] += stages.times().seconds[prior];
  result.times.total_seconds = SecondsSince(start);
  return result;
}

LocalizeResult Localizer::Impl::Localize(const LocalizeQuery& query, const MapSnapshot* pinned) {
  query.Validate();
  if (tiles != nullptr) {
    return LocalizeIn(query, {*tiles});
  }
  const auto localize_in = [&](const MapSnapshot& snapshot) {
    return LocalizeIn(query, {SnapshotTiles(snapshot), &snapshot});
  };
  return pinned != nullptr ? localize_in(*pinned) : ReadLatest(*store, query.deadline, localize_in);
}

LocalizeResult Localizer::Impl::LocalizeIn(const LocalizeQuery& query,
                                           const VersionToRead& version) {
  return WithEitherCamera(query, [&](const LocalizeQuery& meant) {
    return meant.prior ? LocalizeNear(meant, version, nullptr).result
                       : LocalizeAnywhere(meant, version);
  });
}

Localizer Localizer::Open(const std::string& path_or_url, const LocalizerOptions& options,
                          size_t cache_bytes) {
  return {std::make_shared<const MapStore>(MapStore::Open(path_or_url, OpenMode::kReadOnly)),
          options, cache_bytes};
}

Localizer::Localizer(std::shared_ptr<const MapStore> map, const LocalizerOptions& options,
                     size_t cache_bytes)
    : Localizer(std::move(map), options,
                std::make_shared<TileCache>(cache_bytes, options.matching.index)) {}

Localizer::Localizer(std::shared_ptr<const MapStore> map, const LocalizerOptions& options,
                     std::shared_ptr<TileCache> cache) {
  options.Validate();
  RequireIndexesAs(options, *cache);
  impl_.reset(new Impl{std::move(map), nullptr, std::move(cache), options,
                       SharedWorkers(options.num_threads)});
}

Localizer::Localizer(const MapTiles& tiles, const LocalizerOptions& options,
                     std::shared_ptr<TileCache> cache) {
  options.Validate();
  RequireIndexesAs(options, *cache);
  impl_.reset(
      new Impl{nullptr, &tiles, std::move(cache), options, SharedWorkers(options.num_threads)});
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
