#include "engine/refinement/rank_keyframes.h"

#include <algorithm>
#include <cstdint>
#include <tuple>

#include "engine/refinement/bernoulli_divergence.h"

namespace cairn {
namespace {

Rigid3d AnchorFromCam(const std::vector<TileView>& tiles, const KeyframeRef& ref) {
  const TileView& view = tiles[ref.tile_idx];
  return view.anchor_from_tile *
         view.tile->covisibility().keyframes[ref.keyframe_idx].cam_from_tile.Inverse();
}

Eigen::Vector3d CenterInTile(const TileCovisibility& tile, size_t keyframe_idx) {
  const Rigid3d& cam_from_tile = tile.keyframes[keyframe_idx].cam_from_tile;
  return -(cam_from_tile.rotation.conjugate() * cam_from_tile.translation);
}

Eigen::Vector3d CenterInAnchor(const std::vector<TileView>& tiles, const KeyframeRef& ref) {
  const TileView& view = tiles[ref.tile_idx];
  return view.anchor_from_tile * CenterInTile(view.tile->covisibility(), ref.keyframe_idx);
}

// Returns the keyframes of all tiles, in order of tile and keyframe.
std::vector<RankedKeyframe> AllKeyframes(const std::vector<TileView>& tiles) {
  std::vector<RankedKeyframe> keyframes;
  for (size_t t = 0; t < tiles.size(); ++t) {
    for (uint32_t k = 0; k < tiles[t].tile->covisibility().num_keyframes(); ++k) {
      keyframes.push_back({.keyframe = {static_cast<int>(t), k}});
    }
  }
  return keyframes;
}

// Counts the votes for every keyframe, in order of tile and keyframe.
std::vector<RankedKeyframe> CountVotes(const std::vector<TileView>& tiles,
                                       const std::vector<Correspondence>& correspondences) {
  std::vector<LandmarkId> ids;
  for (const Correspondence& match : correspondences) {
    ids.push_back(tiles[match.tile_idx].tile->landmarks().landmark_ids[match.landmark_idx]);
  }
  std::vector<RankedKeyframe> counted = AllKeyframes(tiles);
  // The last keypoint that voted for each keyframe. Matches of a keypoint are adjacent.
  std::vector<int> last_voter(counted.size(), -1);
  size_t first = 0;                     // Index of the tile's first keyframe.
  for (const TileView& view : tiles) {  // One by one: the table of a tile fits into the cache.
    for (size_t i = 0; i < ids.size(); ++i) {
      const int keypoint_idx = correspondences[i].keypoint_idx;
      for (const uint32_t keyframe_idx : view.tile->landmark_keyframes().KeyframesThatSaw(ids[i])) {
        int& voter = last_voter[first + keyframe_idx];
        counted[first + keyframe_idx].num_votes += voter != keypoint_idx;
        voter = keypoint_idx;
      }
    }
    first += view.tile->covisibility().num_keyframes();
  }
  return counted;
}

double LogPrior(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor) {
  if (!region.has_prior) {
    return 0.0;
  }
  const double sigma_m = std::max(1.0, region.prior_sigma_m);
  return -(center_in_anchor.head<2>() - region.prior_xy_in_anchor).squaredNorm() /
         (2.0 * sigma_m * sigma_m);
}

bool IsSameLocation(const Rigid3d& anchor_from_a, const Rigid3d& anchor_from_b,
                    double min_separation_m) {
  constexpr double kMinCosine = 0.70710678;  // 45 degrees between the viewing directions.
  return (anchor_from_a.translation - anchor_from_b.translation).norm() < min_separation_m &&
         (anchor_from_a.rotation * Eigen::Vector3d::UnitZ())
                 .dot(anchor_from_b.rotation * Eigen::Vector3d::UnitZ()) > kMinCosine;
}

// Returns the best keyframe of each location. `ranked` is in order of rank.
std::vector<RankedKeyframe> BestOfEachLocation(const std::vector<TileView>& tiles,
                                               const std::vector<RankedKeyframe>& ranked,
                                               const RefinementOptions& options) {
  std::vector<RankedKeyframe> kept;
  std::vector<Rigid3d> kept_poses;
  for (const RankedKeyframe& candidate : ranked) {
    if (static_cast<int>(kept.size()) >= options.max_keyframes) {
      break;
    }
    const Rigid3d anchor_from_cam = AnchorFromCam(tiles, candidate.keyframe);
    const bool is_new =
        std::none_of(kept_poses.begin(), kept_poses.end(), [&](const Rigid3d& other) {
          return IsSameLocation(anchor_from_cam, other, options.min_separation_m);
        });
    if (is_new) {
      kept.push_back(candidate);
      kept_poses.push_back(anchor_from_cam);
    }
  }
  return kept;
}

}  // namespace

std::vector<RankedKeyframe> RankKeyframes(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const std::vector<Correspondence>& correspondences,
                                          const RefinementOptions& options) {
  std::vector<RankedKeyframe> counted = CountVotes(tiles, correspondences);
  const auto num_observations_of = [&](const KeyframeRef& ref) {
    return static_cast<double>(
        tiles[ref.tile_idx].tile->covisibility().LandmarksOfKeyframe(ref.keyframe_idx).size());
  };
  double num_votes = 0.0, num_observations = 0.0;
  for (const RankedKeyframe& entry : counted) {
    num_votes += entry.num_votes;
    num_observations += num_observations_of(entry.keyframe);
  }
  std::vector<RankedKeyframe> ranked;
  for (RankedKeyframe& entry : counted) {
    const double p = num_observations_of(entry.keyframe) / num_observations;
    if (entry.num_votes > num_votes * p) {
      entry.log_score = num_votes * BernoulliDivergence(entry.num_votes / num_votes, p) +
                        LogPrior(query.region, CenterInAnchor(tiles, entry.keyframe));
      ranked.push_back(entry);
    }
  }
  std::stable_sort(
      ranked.begin(), ranked.end(),
      [](const RankedKeyframe& a, const RankedKeyframe& b) { return a.log_score > b.log_score; });
  return BestOfEachLocation(tiles, ranked, options);
}

std::vector<KeyframeRef> KeyframeNeighborhood(const std::vector<TileView>& tiles,
                                              const KeyframeRef& keyframe, int num_neighbors) {
  constexpr double kMaxDistanceM = 50.0;
  const SearchableTile& own_tile = *tiles[keyframe.tile_idx].tile;
  const auto own_landmarks = own_tile.covisibility().LandmarksOfKeyframe(keyframe.keyframe_idx);
  const Eigen::Vector3d own_center = CenterInAnchor(tiles, keyframe);

  // Minus the number of shared landmarks, tile, keyframe.
  std::vector<std::tuple<int, int, uint32_t>> shared;
  for (int t = 0; t < static_cast<int>(tiles.size()); ++t) {
    const TileCovisibility& tile = tiles[t].tile->covisibility();
    const LandmarkKeyframes& landmark_keyframes = tiles[t].tile->landmark_keyframes();
    std::vector<int> num_shared(tile.num_keyframes(), 0);
    for (const uint32_t landmark_idx : own_landmarks) {
      const LandmarkId id = own_tile.landmarks().landmark_ids[landmark_idx];
      for (const uint32_t keyframe_idx : landmark_keyframes.KeyframesThatSaw(id)) {
        ++num_shared[keyframe_idx];
      }
    }
    const Eigen::Vector3d own_center_in_tile = tiles[t].anchor_from_tile.Inverse() * own_center;
    for (uint32_t k = 0; k < tile.num_keyframes(); ++k) {
      const bool is_own = t == keyframe.tile_idx && k == keyframe.keyframe_idx;
      if (num_shared[k] > 0 && !is_own &&
          (CenterInTile(tile, k) - own_center_in_tile).norm() <= kMaxDistanceM) {
        shared.emplace_back(-num_shared[k], t, k);
      }
    }
  }
  std::sort(shared.begin(), shared.end());
  std::vector<KeyframeRef> neighborhood = {keyframe};
  for (const auto& [minus_shared, tile_idx, keyframe_idx] : shared) {
    if (static_cast<int>(neighborhood.size()) > num_neighbors) {
      break;
    }
    neighborhood.push_back({tile_idx, keyframe_idx});
  }
  return neighborhood;
}

}  // namespace cairn
