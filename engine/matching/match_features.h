// Stage `matching`: finds 2D-3D correspondences between a query and tiles.
#ifndef CAIRN_ENGINE_MATCHING_MATCH_FEATURES_H_
#define CAIRN_ENGINE_MATCHING_MATCH_FEATURES_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/shared_workers.h"
#include "core/stop_function.h"
#include "engine/index/byte_scale.h"
#include "engine/index/code_expansion.h"
#include "engine/matching/landmark_ranking.h"
#include "engine/matching/matching_options.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

struct FeatureMatches {
  std::vector<Correspondence> correspondences;
  int64_t num_matched_keypoints = 0;
  int64_t num_distances = 0;  // Descriptor distances computed, in this call.
  bool was_stopped = false;   // Some keypoints were not searched everywhere.
};

// For each keypoint, returns the k best landmarks over all tiles that pass the filters, except
// those that have enough nearer keypoints (max_keypoints_of_landmark): no other landmark replaces
// these. A landmark in several tiles counts once (its nearest copy). Results are ordered by
// keypoint, then distance, then landmark id. `workers` (may be null) share the work by ranges of
// keypoints; the result does not depend on them. Polls `should_stop`; once it returns true, the
// search ends with the correspondences found so far. Throws Error(kInternal) unless all tiles share
// the codebook with which the query's descriptors were projected. The check compares codebook ids
// among the tiles, and the dimension with the query.
FeatureMatches MatchFeatures(const QueryContext& query, const std::vector<TileView>& tiles,
                             const MatchingOptions& options, SharedWorkers* workers = nullptr,
                             const StopFunction& should_stop = {});

// Returns the keypoints in the order in which they are worth matching: the largest first. Large
// features are more often seen again, and from farther away. Equals are in an order that has
// nothing to do with their places in the image.
std::vector<int> KeypointsByValue(const QueryContext& query);

// Does the same in rounds. A round matches more keypoints, and no match is computed twice. A match
// of an earlier round is left out if its landmark now has enough nearer keypoints. After a round
// over all keypoints, the correspondences are those of MatchFeatures.
class FeatureMatcher {
 public:
  // There must be a tile. The arguments must outlive the matcher. Throws as MatchFeatures.
  FeatureMatcher(const QueryContext& query, const std::vector<TileView>& tiles,
                 const MatchingOptions& options);
  FeatureMatcher(const FeatureMatcher&) = delete;  // The ranking refers to the order.
  FeatureMatcher& operator=(const FeatureMatcher&) = delete;

  // Matches the keypoints that are worth most, so that `num_keypoints` of them have been matched.
  // Returns the correspondences of all of these in the order of MatchFeatures.
  FeatureMatches MatchUpTo(int num_keypoints, SharedWorkers* workers,
                           const StopFunction& should_stop);

 private:
  const QueryContext& query_;
  const std::vector<TileView>& tiles_;
  const MatchingOptions& options_;
  const std::vector<int> order_;
  const DescriptorMatrix descriptors_;  // In this order.
  LandmarkRanking ranking_;
  int num_matched_ = 0;  // The first ones in this order have been matched.
};

struct KeyframeRef {
  int tile_idx = 0;
  uint32_t keyframe_idx = 0;

  bool operator==(const KeyframeRef&) const = default;
};

// Matches all keypoints against only the landmarks that some keyframes saw, for the refinement
// stage. The search is exhaustive, with the absolute threshold at `distance_quantile` whatever the
// distance filter. Order and rules are those of MatchFeatures. Safe to call from any thread.
class KeyframeMatcher {
 public:
  // The query, the tiles and the options must outlive the matcher. Throws as MatchFeatures.
  KeyframeMatcher(const QueryContext& query, const std::vector<TileView>& tiles,
                  double distance_quantile, const MatchingOptions& options);

  // Keyframes may repeat.
  std::vector<Correspondence> Match(const std::vector<KeyframeRef>& keyframes) const;

 private:
  // What the codebook and the query make the same for all keyframes.
  struct Prepared {
    const Codebook& codebook;
    ByteScale scale;
    CodeWords words;
    std::vector<int16_t> query_steps;
    std::vector<double> max_distances;
  };

  // Compares every keypoint with every descriptor of `codes`.
  void SearchAll(std::span<const uint8_t> codes, HitReceiver* receiver) const;

  const QueryContext& query_;
  const std::vector<TileView>& tiles_;
  const MatchingOptions& options_;
  std::optional<Prepared> prepared_;  // Empty if there are no tiles.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_MATCH_FEATURES_H_
