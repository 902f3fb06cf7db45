#include "engine/matching/match_features.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/large_vector.h"
#include "core/random.h"
#include "engine/index/byte_scale.h"
#include "engine/index/cell_lists.h"
#include "engine/index/code_expansion.h"
#include "engine/index/shared_visits.h"
#include "engine/matching/landmark_ranking.h"
#include "engine/tiles/descriptor_places.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

// Descriptor indices, ascending, and the landmark of each.
struct SomeDescriptors {
  std::vector<uint32_t> descriptors;
  LargeVector<uint32_t> landmarks;
};

// Returns the descriptors of the landmarks that any of the keyframes of one tile saw.
SomeDescriptors DescriptorsOfKeyframes(const SearchableTile& tile,
                                       std::span<const uint32_t> keyframe_indices) {
  std::vector<uint32_t> seen;
  for (const uint32_t keyframe_idx : keyframe_indices) {
    const auto landmarks = tile.covisibility().LandmarksOfKeyframe(keyframe_idx);
    seen.insert(seen.end(), landmarks.begin(), landmarks.end());
  }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  SomeDescriptors some;
  const std::span<const uint32_t> descriptor_begin = tile.landmarks().descriptor_begin;
  for (const uint32_t landmark_idx : seen) {
    for (uint32_t i = descriptor_begin[landmark_idx]; i < descriptor_begin[landmark_idx + 1]; ++i) {
      some.descriptors.push_back(i);
      some.landmarks.push_back(landmark_idx);
    }
  }
  return some;
}

// Returns the codebook that all tiles share, with which the query's descriptors were projected.
const Codebook& CommonCodebook(const std::vector<TileView>& tiles) {
  const Codebook& codebook = tiles.front().tile->codebook();
  for (const TileView& view : tiles) {
    if (view.tile->codebook().id != codebook.id) {
      throw Error(ErrorCode::kInternal,
                  fmt::format("tiles {} and {} have different codebooks ({} and {})",
                              tiles.front().tile->id().ToString(), view.tile->id().ToString(),
                              Value(codebook.id), Value(view.tile->codebook().id)));
    }
  }
  return codebook;
}

// Returns the largest distance of a match for each query descriptor.
std::vector<double> MaxDistances(const DescriptorMatrix& queries, const SearchableTile& tile,
                                 const MatchingOptions& options) {
  switch (options.distance_filter) {
    case DistanceFilter::kAbsolute:
      return std::vector<double>(queries.rows(),
                                 SameLandmarkDistance(tile.codebook(), options.distance_quantile));
    case DistanceFilter::kWordRatio: {
      std::vector<double> distances = tile.ReferenceDistances(queries);
      for (double& distance : distances) {
        distance *= options.max_word_ratio;
      }
      return distances;
    }
    case DistanceFilter::kNone:
      break;
  }
  return std::vector<double>(queries.rows(), std::numeric_limits<double>::infinity());
}

// Keypoints of a query with consecutive ranks.
struct KeypointRange {
  int begin = 0;
  int end = 0;
  int size() const { return end - begin; }
};

// Splits a range into about equal ones, at most one per thread. Short ranges do not pay: loading a
// list of descriptors into the cache costs the same however few keypoints are compared with it.
std::vector<KeypointRange> SplitKeypoints(const KeypointRange& all, int num_threads) {
  constexpr int kMinRangeSize = 128;
  const int count = std::clamp(all.size() / kMinRangeSize, 1, num_threads);
  std::vector<KeypointRange> ranges;
  for (int i = 0; i < count; ++i) {
    ranges.push_back({all.begin + static_cast<int>(int64_t{all.size()} * i / count),
                      all.begin + static_cast<int>(int64_t{all.size()} * (i + 1) / count)});
  }
  return ranges;
}

// Searches one tile for a range of keypoints, whose descriptors are `queries`, and adds the hits to
// the ranking without touching its other keypoints. Returns the number of distances computed.
int64_t SearchTile(const DescriptorMatrix& queries, const KeypointRange& range,
                   const TileView& view, int tile_idx, const MatchingOptions& options,
                   const StopFunction& should_stop, SharedVisits* shared_visits,
                   LandmarkRanking* ranking) {
  std::vector<double> max_distances = MaxDistances(queries, *view.tile, options);
  for (int i = 0; i < range.size(); ++i) {
    max_distances[i] = std::min(max_distances[i], ranking->MaxUsefulDistance(range.begin + i));
  }
  LandmarkRanking::TileHits tile_hits(ranking, view, view.tile->places(), tile_idx,
                                      static_cast<uint32_t>(range.begin));
  const int64_t num_distances = view.tile->index().Search({.queries = queries,
                                                           .max_distances = max_distances,
                                                           .receiver = &tile_hits,
                                                           .shared_visits = shared_visits,
                                                           .should_stop = should_stop},
                                                          nullptr);
  tile_hits.Flush();
  return num_distances;
}

// The correspondences are ordered by keypoint.
int64_t NumKeypoints(const std::vector<Correspondence>& correspondences) {
  int64_t num_keypoints = 0;
  for (size_t i = 0; i < correspondences.size(); ++i) {
    const bool is_new =
        i == 0 || correspondences[i].keypoint_idx != correspondences[i - 1].keypoint_idx;
    num_keypoints += is_new ? 1 : 0;
  }
  return num_keypoints;
}

// Returns the codes of some descriptors, in the given order.
std::vector<uint8_t> GatherCodes(const SearchableTile& tile,
                                 std::span<const uint32_t> descriptors) {
  const size_t code_size = tile.codebook().num_subspaces;
  const std::span<const uint8_t> tile_codes = tile.codes();
  std::vector<uint8_t> codes;
  codes.reserve(descriptors.size() * code_size);
  for (const uint32_t descriptor : descriptors) {
    const std::span<const uint8_t> code = tile_codes.subspan(descriptor * code_size, code_size);
    codes.insert(codes.end(), code.begin(), code.end());
  }
  return codes;
}

}  // namespace

std::vector<int> KeypointsByValue(const QueryContext& query) {
  constexpr uint64_t kSeed = 1;
  std::vector<int> order(query.num_keypoints());
  Random random(kSeed);
  for (int i = 0; i < query.num_keypoints(); ++i) {  // A random permutation.
    const int j = random.Index(i + 1);
    order[i] = order[j];
    order[j] = i;
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return query.keypoints[a].scale_px > query.keypoints[b].scale_px;
  });
  return order;
}

FeatureMatcher::FeatureMatcher(const QueryContext& query, const std::vector<TileView>& tiles,
                               const MatchingOptions& options)
    : query_(query),
      tiles_(tiles),
      options_(options),
      order_(KeypointsByValue(query)),
      descriptors_(query.descriptors(order_, Eigen::all)),
      ranking_(query, CommonCodebook(tiles), options, order_) {}

FeatureMatches FeatureMatcher::MatchUpTo(int num_keypoints, SharedWorkers* workers,
                                         const StopFunction& should_stop) {
  const std::vector<KeypointRange> ranges =
      SplitKeypoints({num_matched_, num_keypoints}, workers != nullptr ? workers->NumFree() : 1);
  num_matched_ = num_keypoints;
  std::vector<int64_t> num_distances(ranges.size(), 0);
  std::atomic<bool> was_stopped = false;
  const StopFunction stop_all = [&] {
    if (should_stop && should_stop()) {
      was_stopped = true;
    }
    return was_stopped.load();
  };
  ForEachStep(workers, static_cast<int>(ranges.size()), [&](int i) {
    const DescriptorMatrix queries = descriptors_.middleRows(ranges[i].begin, ranges[i].size());
    SharedVisits shared_visits;
    for (size_t tile_idx = 0; tile_idx < tiles_.size(); ++tile_idx) {
      if (stop_all()) {
        return;
      }
      num_distances[i] +=
          SearchTile(queries, ranges[i], tiles_[tile_idx], static_cast<int>(tile_idx), options_,
                     stop_all, &shared_visits, &ranking_);
    }
  });
  std::vector<Correspondence> correspondences = ranking_.Correspondences(tiles_);
  const int64_t num_matched_keypoints = NumKeypoints(correspondences);
  return {.correspondences = std::move(correspondences),
          .num_matched_keypoints = num_matched_keypoints,
          .num_distances = std::accumulate(num_distances.begin(), num_distances.end(), int64_t{0}),
          .was_stopped = was_stopped};
}

FeatureMatches MatchFeatures(const QueryContext& query, const std::vector<TileView>& tiles,
                             const MatchingOptions& options, SharedWorkers* workers,
                             const StopFunction& should_stop) {
  return tiles.empty() ? FeatureMatches()
                       : FeatureMatcher(query, tiles, options)
                             .MatchUpTo(query.num_keypoints(), workers, should_stop);
}

KeyframeMatcher::KeyframeMatcher(const QueryContext& query, const std::vector<TileView>& tiles,
                                 double distance_quantile, const MatchingOptions& options)
    : query_(query), tiles_(tiles), options_(options) {
  if (!tiles.empty()) {
    const Codebook& codebook = CommonCodebook(tiles);
    const ByteScale scale(codebook);
    RequireQueryDim(query.descriptors, scale.dim());
    prepared_.emplace(Prepared{
        codebook, scale, CodeWords(codebook, scale), scale.QuantizeQueries(query.descriptors),
        std::vector<double>(query.num_keypoints(),
                            SameLandmarkDistance(codebook, distance_quantile))});
  }
}

std::vector<Correspondence> KeyframeMatcher::Match(
    const std::vector<KeyframeRef>& keyframes) const {
  if (!prepared_) {
    return {};
  }
  std::vector<std::vector<uint32_t>> keyframes_of_tile(tiles_.size());
  for (const KeyframeRef& keyframe : keyframes) {
    keyframes_of_tile[keyframe.tile_idx].push_back(keyframe.keyframe_idx);
  }
  LandmarkRanking ranking(query_, prepared_->codebook, options_);
  for (size_t tile_idx = 0; tile_idx < tiles_.size(); ++tile_idx) {
    if (keyframes_of_tile[tile_idx].empty()) {
      continue;
    }
    const SearchableTile& tile = *tiles_[tile_idx].tile;
    SomeDescriptors some = DescriptorsOfKeyframes(tile, keyframes_of_tile[tile_idx]);
    const std::vector<uint8_t> codes = GatherCodes(tile, some.descriptors);
    const DescriptorPlaces places(tile.landmarks(), tile.places().grid(), some.descriptors,
                                  std::move(some.landmarks));
    LandmarkRanking::TileHits tile_hits(&ranking, tiles_[tile_idx], places,
                                        static_cast<int>(tile_idx));
    SearchAll(codes, &tile_hits);
    tile_hits.Flush();
  }
  return ranking.Correspondences(tiles_);
}

void KeyframeMatcher::SearchAll(std::span<const uint8_t> codes, HitReceiver* receiver) const {
  BlockedRows rows(prepared_->words, codes);
  TileLists list = ListsOfCells(std::vector<uint32_t>(rows.size(), 0), 1);
  const CellLists descriptors(prepared_->scale, std::move(rows), std::move(list));
  std::vector<CellVisit> visits(query_.num_keypoints());
  for (size_t i = 0; i < visits.size(); ++i) {
    visits[i].query_idx = static_cast<uint32_t>(i);
  }
  HitCollector collector(prepared_->scale, {.queries = query_.descriptors,
                                            .max_distances = prepared_->max_distances,
                                            .receiver = receiver});
  descriptors.Search(descriptors.Prepare(prepared_->query_steps), visits, &collector);
}

}  // namespace cairn
