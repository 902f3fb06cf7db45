#include "engine/matching/match_features.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "core/error.h"
#include "engine/matching/byte_descriptors.h"
#include "engine/matching/distance_statistics.h"
#include "engine/matching/landmark_ranking.h"

namespace cairn {
namespace {

// Descriptors of the landmarks that any of the keyframes of one tile saw, ascending.
std::vector<uint32_t> DescriptorsOfKeyframes(const Tile& tile,
                                             std::span<const uint32_t> keyframe_indices) {
  std::vector<bool> seen(tile.num_landmarks(), false);
  for (const uint32_t keyframe_idx : keyframe_indices) {
    for (const uint32_t landmark_idx : tile.LandmarksOfKeyframe(keyframe_idx)) {
      seen[landmark_idx] = true;
    }
  }
  std::vector<uint32_t> descriptors;
  for (size_t landmark_idx = 0; landmark_idx < seen.size(); ++landmark_idx) {
    if (seen[landmark_idx]) {
      for (uint32_t i = tile.descriptor_begin[landmark_idx];
           i < tile.descriptor_begin[landmark_idx + 1]; ++i) {
        descriptors.push_back(i);
      }
    }
  }
  return descriptors;
}

// All tiles share one codebook: the one the query's descriptors were projected with.
const Codebook& CommonCodebook(const std::vector<TileView>& tiles) {
  const Codebook& codebook = tiles.front().tile->codebook();
  for (const TileView& view : tiles) {
    if (view.tile->codebook().id != codebook.id) {
      throw Error(
          ErrorCode::kInternal,
          fmt::format("tiles {} and {} have different codebooks ({} and {})",
                      tiles.front().tile->tile().id.ToString(), view.tile->tile().id.ToString(),
                      Value(codebook.id), Value(view.tile->codebook().id)));
    }
  }
  return codebook;
}

// How far from each query descriptor a match may be.
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

// Hands on hits of some of a tile's descriptors as those of the tile.
class HitsOfSome : public HitReceiver {
 public:
  HitsOfSome(std::span<const uint32_t> descriptors, HitReceiver* receiver)
      : descriptors_(descriptors), receiver_(receiver) {}

  float Take(const DescriptorHit& hit) override {
    return receiver_->Take({hit.query_idx, descriptors_[hit.descriptor_idx], hit.sq_distance});
  }

 private:
  const std::span<const uint32_t> descriptors_;
  HitReceiver* receiver_;
};

// The codes of some descriptors, in the order given.
std::vector<uint8_t> GatherCodes(const Tile& tile, std::span<const uint32_t> descriptors) {
  std::vector<uint8_t> codes;
  codes.reserve(descriptors.size() * tile.code_size);
  for (const uint32_t descriptor : descriptors) {
    const auto first = tile.codes.begin() + static_cast<ptrdiff_t>(descriptor) * tile.code_size;
    codes.insert(codes.end(), first, first + tile.code_size);
  }
  return codes;
}

}  // namespace

std::vector<Correspondence> MatchFeatures(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const MatchingOptions& options, StageCounters* counters) {
  if (tiles.empty()) {
    return {};
  }
  const Codebook& codebook = CommonCodebook(tiles);
  LandmarkRanking ranking(query, codebook, options);
  for (size_t tile_idx = 0; tile_idx < tiles.size(); ++tile_idx) {
    const SearchableTile& tile = *tiles[tile_idx].tile;
    std::vector<double> max_distances = MaxDistances(query.descriptors, tile, options);
    for (size_t keypoint_idx = 0; keypoint_idx < max_distances.size(); ++keypoint_idx) {
      max_distances[keypoint_idx] =
          std::min(max_distances[keypoint_idx],
                   ranking.MaxUsefulDistance(static_cast<uint32_t>(keypoint_idx)));
    }
    LandmarkRanking::TileHits tile_hits(&ranking, tiles[tile_idx], static_cast<int>(tile_idx));
    counters->num_distances += tile.index().Search(
        {.queries = query.descriptors, .max_distances = max_distances, .receiver = &tile_hits},
        nullptr);
    tile_hits.Flush();
  }
  std::vector<Correspondence> correspondences = ranking.Correspondences(tiles);
  counters->num_matches = static_cast<int64_t>(correspondences.size());
  counters->num_matched_keypoints = ranking.NumMatchedKeypoints();
  return correspondences;
}

std::vector<Correspondence> MatchAgainstKeyframes(const QueryContext& query,
                                                  const std::vector<TileView>& tiles,
                                                  const std::vector<KeyframeRef>& keyframes,
                                                  double distance_quantile,
                                                  const MatchingOptions& options) {
  if (tiles.empty()) {
    return {};
  }
  const Codebook& codebook = CommonCodebook(tiles);
  const std::vector<double> max_distances(query.num_keypoints(),
                                          SameLandmarkDistance(codebook, distance_quantile));
  std::vector<std::vector<uint32_t>> keyframes_of_tile(tiles.size());
  for (const KeyframeRef& keyframe : keyframes) {
    keyframes_of_tile[keyframe.tile_idx].push_back(keyframe.keyframe_idx);
  }
  LandmarkRanking ranking(query, codebook, options);
  for (size_t tile_idx = 0; tile_idx < tiles.size(); ++tile_idx) {
    const SearchableTile& tile = *tiles[tile_idx].tile;
    const std::vector<uint32_t> descriptors =
        DescriptorsOfKeyframes(tile.tile(), keyframes_of_tile[tile_idx]);
    LandmarkRanking::TileHits tile_hits(&ranking, tiles[tile_idx], static_cast<int>(tile_idx));
    HitsOfSome some_hits(descriptors, &tile_hits);
    ByteDescriptors(codebook, GatherCodes(tile.tile(), descriptors))
        .Search(
            {.queries = query.descriptors, .max_distances = max_distances, .receiver = &some_hits},
            nullptr);
    tile_hits.Flush();
  }
  return ranking.Correspondences(tiles);
}

}  // namespace cairn
