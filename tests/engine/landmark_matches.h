// Matches with small tiles, by the ids of their landmarks.
#ifndef CAIRN_TESTS_ENGINE_LANDMARK_MATCHES_H_
#define CAIRN_TESTS_ENGINE_LANDMARK_MATCHES_H_

#include <cstdint>
#include <vector>

#include "engine/matching/match_features.h"

namespace cairn::testing {

// Byte steps are 1.5 / 255, so distances are off by less than this.
inline constexpr float kDistanceTolerance = 0.02f;

inline std::vector<Correspondence> Match(const QueryContext& query,
                                         const std::vector<TileView>& tiles,
                                         const MatchingOptions& options = {}) {
  return MatchFeatures(query, tiles, options).correspondences;
}

inline std::vector<uint64_t> LandmarkIds(const std::vector<TileView>& tiles,
                                         const std::vector<Correspondence>& matches) {
  std::vector<uint64_t> ids;
  for (const Correspondence& match : matches) {
    ids.push_back(Value(tiles[match.tile_idx].tile->landmarks().landmark_ids[match.landmark_idx]));
  }
  return ids;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_LANDMARK_MATCHES_H_
