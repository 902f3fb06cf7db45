// Turns descriptor hits into correspondences: applies the prior terms and the hard filters, and
// keeps the k best landmarks of each keypoint, and of these the best keypoints of each landmark.
#ifndef CAIRN_ENGINE_MATCHING_LANDMARK_RANKING_H_
#define CAIRN_ENGINE_MATCHING_LANDMARK_RANKING_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/index/hit_collector.h"
#include "engine/matching/matching_options.h"
#include "engine/query/query_context.h"
#include "engine/tiles/descriptor_places.h"
#include "engine/tiles/searchable_tile.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// For every keypoint of a query, keeps the max_neighbors landmarks with the smallest distance among
// all hits added so far. A landmark counts once, by its best descriptor in any tile. Equal
// distances are ordered by landmark id, then tile and descriptor. Threads may share a ranking if
// each thread adds hits of its own keypoints only.
class LandmarkRanking {
 public:
  class TileHits;  // Adds hits.

  // Knows keypoints by their rank in `order`, a permutation of the query's keypoints; if empty, by
  // their index. The arguments must outlive the ranking.
  LandmarkRanking(const QueryContext& query, const Codebook& codebook,
                  const MatchingOptions& options, std::span<const int> order = {});

  // Returns the distance, in projected space, beyond which a descriptor can no longer become a
  // correspondence of the keypoint, whatever its landmark. Infinity while the keypoint has fewer
  // than max_neighbors neighbors.
  double MaxUsefulDistance(uint32_t rank) const;

  // The square of MaxUsefulDistance.
  float MaxUsefulSqDistance(uint32_t rank) const { return max_useful_sq_distances_[rank]; }

  // Returns the correspondences, ordered by keypoint, then distance: the neighbors of all
  // keypoints, but of each landmark only the max_keypoints_of_landmark nearest. Equally near
  // keypoints are taken in their order. `tiles` must be the tiles whose hits were added.
  std::vector<Correspondence> Correspondences(const std::vector<TileView>& tiles) const;

 private:
  struct Neighbor {
    float sq_distance = 0.0f;  // Including the prior terms.
    int tile_idx = 0;
    uint32_t landmark_idx = 0;
    uint32_t descriptor_idx = 0;
    LandmarkId landmark_id{};
  };

  // The direction of an orientation.
  struct Direction {
    float cos = 0.0f;
    float sin = 0.0f;
    float is_known = 0.0f;  // 1, or 0 if the orientation is unknown.
  };

  // Returns the direction of each orientation code.
  static const std::array<Direction, 256>& CodeDirections();
  // Returns the squared chord between two orientations, 2 - 2 cos, in [0, 4]; 0 if one is unknown.
  static float SqChord(const Direction& a, const Direction& b) {
    const float x = a.cos - b.cos, y = a.sin - b.sin;
    return a.is_known * b.is_known * (x * x + y * y);
  }

  static bool IsCloser(const Neighbor& a, const Neighbor& b);

  // Returns the square of e / prior sigma, where e is how far a landmark is out of view; see
  // MatchingOptions::position_weight. x_from_prior is horizontal, meters.
  float SqPositionExcess(const Eigen::Vector2f& x_from_prior) const;
  int KeypointAt(int rank) const { return order_.empty() ? rank : order_[rank]; }
  void Insert(uint32_t rank, const Neighbor& neighbor);
  // Tells of each of neighbors_ whether enough other keypoints are nearer to its landmark.
  std::vector<bool> FindSurplus() const;
  // Calls `visit(rank, index into neighbors_)` for each neighbor of each keypoint.
  template <typename Visit>
  void ForEachNeighbor(const Visit& visit) const {
    for (size_t rank = 0; rank < num_neighbors_.size(); ++rank) {
      for (int i = 0; i < num_neighbors_[rank]; ++i) {
        visit(static_cast<int>(rank), rank * options_.max_neighbors + i);
      }
    }
  }
  // Returns the squared distance of the descriptors alone, up to rounding.
  float DescriptorSqDistance(int rank, const Neighbor& neighbor, const TileView& view) const;
  // Prefetches the data of a keypoint's landmarks that Correspondences reads. The landmarks are
  // scattered over the tiles.
  void PrefetchNeighbors(int rank, const std::vector<TileView>& tiles) const;
  Correspondence MakeCorrespondence(int rank, const Neighbor& neighbor, const TileView& view) const;

  const QueryContext& query_;
  const MatchingOptions& options_;
  const std::span<const int> order_;
  float orientation_factor_ = 0.0f;  // Factor of the squared chord.
  float position_factor_ = 0.0f;     // Factor of the squared excess.
  // Bounds of the hard filters.
  float max_sq_chord_ = 4.0f;
  float max_sq_excess_ = std::numeric_limits<float>::infinity();
  bool uses_position_ = false;  // True if the region has a prior and an option uses it.
  // The arrays below are in order of rank.
  std::vector<Direction> keypoint_directions_;
  std::vector<Neighbor> neighbors_;  // num_keypoints x max_neighbors, each row sorted by IsCloser.
  std::vector<int> num_neighbors_;   // Number of used entries in each row.
  // The squared distance of each keypoint's last neighbor; infinity while it has fewer than
  // max_neighbors.
  std::vector<float> max_useful_sq_distances_;
};

// Adds the hits of one tile to a ranking. Each hit passes three stages, and the memory that a stage
// reads is prefetched while other hits are processed. The first stage reads the hit's place, which
// rejects most hits; the second reads its landmark index; the third reads the landmark, which lies
// anywhere in the tile. Because of this delay, MaxUsefulDistance reacts to a hit a little later.
// Use each object from one thread.
class LandmarkRanking::TileHits : public HitReceiver {
 public:
  // The hits belong to the tile_idx-th tile of the query and to the keypoints of rank `first_rank`
  // and after; their rows are places in `places`. All arguments must outlive the object.
  TileHits(LandmarkRanking* ranking, const TileView& view, const DescriptorPlaces& places,
           int tile_idx, uint32_t first_rank = 0);

  float Take(const HitRun& run) override;
  // Adds the hits that are still queued. Call after the last hit.
  void Flush();

 private:
  static constexpr size_t kAhead = 16;  // Length of each queue.

  struct Hit {
    uint32_t rank = 0;  // Of the keypoint.
    uint32_t place = 0;
    float sq_distance = 0.0f;  // With the orientation term.
  };
  struct Candidate {
    uint32_t rank = 0;
    Neighbor neighbor;
  };

  // Processes the hits of the last run.
  void TakeLast();
  // Moves the hits of the last run that may be useful to the front and adds the orientation term.
  // Returns their number.
  size_t Keep();
  // Prefetches a hit's landmark index and queues the hit. If the queue is full, first passes its
  // oldest hit to QueueCandidate.
  void QueueHit(const Hit& hit);
  // Prefetches a hit's landmark and queues it as a candidate. If the queue is full, first ranks its
  // oldest candidate.
  void QueueCandidate(const Hit& hit);
  // Adds the position term and ranks the candidate.
  void Rank(Candidate* candidate);

  LandmarkRanking& ranking_;
  const TileLandmarks& tile_;
  const DescriptorPlaces& places_;
  const int tile_idx_;
  const uint32_t first_rank_;
  // Maps a point of the tile to its horizontal offset from the prior; floats resolve a millimeter.
  Eigen::Matrix<float, 2, 3> prior_from_tile_;
  Eigen::Vector2f tile_in_prior_;
  // Maps a place's CoarseXy to the same offset.
  Eigen::Matrix2f prior_from_coarse_;
  Eigen::Vector2f coarse_in_prior_;
  float max_free_m_ = 0.0f;  // A coarse place up to this distance from the prior may be in view.
  float per_sigma_ = 0.0f;
  // The last run; its distances are still those of the descriptors alone.
  std::vector<Hit> last_;
  size_t num_last_ = 0;
  // Ring buffers that hold the last kAhead hits and candidates.
  std::array<Hit, kAhead> hits_;
  std::array<Candidate, kAhead> candidates_;
  size_t num_hits_ = 0;
  size_t num_candidates_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_LANDMARK_RANKING_H_
