#include "engine/refinement/keyframe_candidates.h"

#include <cstdint>
#include <unordered_set>

#include "engine/refinement/rank_keyframes.h"

namespace cairn {
namespace {

// Packs tile and landmark into one number.
uint64_t LandmarkKey(int tile_idx, uint32_t landmark_idx) {
  return static_cast<uint64_t>(tile_idx) << 32 | landmark_idx;
}

std::unordered_set<uint64_t> LandmarksOf(const std::vector<TileView>& tiles,
                                         const std::vector<KeyframeRef>& keyframes) {
  std::unordered_set<uint64_t> landmarks;
  for (const KeyframeRef& keyframe : keyframes) {
    const TileCovisibility& tile = tiles[keyframe.tile_idx].tile->covisibility();
    for (const uint32_t landmark_idx : tile.LandmarksOfKeyframe(keyframe.keyframe_idx)) {
      landmarks.insert(LandmarkKey(keyframe.tile_idx, landmark_idx));
    }
  }
  return landmarks;
}

}  // namespace

std::vector<PoseCandidate> KeyframeCandidates(const QueryContext& query,
                                              const std::vector<TileView>& tiles,
                                              const std::vector<Correspondence>& correspondences,
                                              const RefinementOptions& options) {
  std::vector<PoseCandidate> candidates;
  for (const RankedKeyframe& ranked : RankKeyframes(query, tiles, correspondences, options)) {
    const auto landmarks = LandmarksOf(
        tiles, KeyframeNeighborhood(tiles, ranked.keyframe, options.neighbors_per_keyframe));
    PoseCandidate candidate;
    int last_keypoint_idx = -1;
    for (size_t i = 0; i < correspondences.size(); ++i) {
      const Correspondence& match = correspondences[i];
      if (!landmarks.contains(LandmarkKey(match.tile_idx, match.landmark_idx))) {
        continue;
      }
      candidate.correspondences.push_back(static_cast<int>(i));
      if (match.keypoint_idx != last_keypoint_idx) {  // Correspondences are ordered by keypoint.
        candidate.score += 1.0;
        last_keypoint_idx = match.keypoint_idx;
      }
    }
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

}  // namespace cairn
