// From descriptor hits to correspondences: prior terms, the hard filters, and the k best landmarks
// of each keypoint.
#ifndef CAIRN_ENGINE_MATCHING_LANDMARK_RANKING_H_
#define CAIRN_ENGINE_MATCHING_LANDMARK_RANKING_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/index/kernels/hit_collector.h"
#include "engine/matching/matching_options.h"
#include "engine/query/query_context.h"
#include "engine/tiles/descriptor_places.h"
#include "engine/tiles/searchable_tile.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Keeps, for every keypoint of a query, the max_neighbors landmarks with the smallest distance
// among all hits added so far. A landmark counts once, by its best descriptor in any tile. Equal
// distances are ordered by landmark id, then tile and descriptor. Threads may share a ranking if
// each has keypoints of its own.
class LandmarkRanking {
 public:
  class TileHits;  // How hits are added.

  // `query` and `options` must outlive the ranking.
  LandmarkRanking(const QueryContext& query, const Codebook& codebook,
                  const MatchingOptions& options);

  // A descriptor farther from the keypoint than this cannot become one of its correspondences any
  // more, whatever its landmark; projected space, infinity while there are fewer than
  // max_neighbors.
  double MaxUsefulDistance(uint32_t keypoint_idx) const;

  // The square of MaxUsefulDistance.
  float MaxUsefulSqDistance(uint32_t keypoint_idx) const {
    return max_useful_sq_distances_[keypoint_idx];
  }

  // Ordered by keypoint, then distance. `tiles` are those that were added.
  std::vector<Correspondence> Correspondences(const std::vector<TileView>& tiles) const;

  int64_t NumMatchedKeypoints() const;

 private:
  struct Neighbor {
    float sq_distance = 0.0f;  // With the prior terms.
    int tile_idx = 0;
    uint32_t landmark_idx = 0;
    uint32_t descriptor_idx = 0;
    LandmarkId landmark_id{};
  };

  // Of an orientation.
  struct Direction {
    float cos = 0.0f;
    float sin = 0.0f;
    float is_known = 0.0f;  // 1, or 0 where there is none.
  };

  // Direction of each orientation code.
  static const std::array<Direction, 256>& CodeDirections();
  // Squared chord between two orientations, (2 - 2 cos), in [0, 4]; 0 if one is not known.
  static float SqChord(const Direction& a, const Direction& b) {
    const float x = a.cos - b.cos, y = a.sin - b.sin;
    return a.is_known * b.is_known * (x * x + y * y);
  }

  static bool IsCloser(const Neighbor& a, const Neighbor& b);

  // Square of how far, in standard deviations of the prior, a landmark is out of its view;
  // x_from_prior is horizontal, metres.
  float SqPositionExcess(const Eigen::Vector2f& x_from_prior) const;
  void Insert(uint32_t keypoint_idx, const Neighbor& neighbor);
  // The squared distance of the descriptors alone, up to rounding.
  float DescriptorSqDistance(int keypoint_idx, const Neighbor& neighbor,
                             const TileView& view) const;
  // Asks for what Correspondences reads of a keypoint's landmarks, which lie anywhere in the tiles.
  void PrefetchNeighbors(int keypoint_idx, const std::vector<TileView>& tiles) const;

  const QueryContext& query_;
  const MatchingOptions& options_;
  float orientation_factor_ = 0.0f;  // Of the squared chord.
  float position_factor_ = 0.0f;     // Of the squared excess.
  // The hard filters.
  float max_sq_chord_ = 4.0f;
  float max_sq_excess_ = std::numeric_limits<float>::infinity();
  bool uses_position_ = false;  // The region has a prior, and one of the options uses it.
  std::vector<Direction> keypoint_directions_;
  std::vector<Neighbor> neighbors_;  // num_keypoints x max_neighbors, each row sorted by IsCloser.
  std::vector<int> num_neighbors_;   // Used entries of each row.
  // Distance of each keypoint's last neighbour, infinity while there are fewer than max_neighbors.
  std::vector<float> max_useful_sq_distances_;
};

// The way of a tile's hits into the ranking. They wait for the memory that they need, while more
// are found: first for what their places say of them, by which most are refused, then for their
// landmarks, then for what is known of these, which lies anywhere in the tile. What a hit says
// about further ones is therefore known a little later. For use within one thread.
class LandmarkRanking::TileHits : public HitReceiver {
 public:
  // The hits are of the tile_idx-th tile of the query, and of its keypoints from `first_keypoint`
  // on; their rows are among `places`. All must outlive this.
  TileHits(LandmarkRanking* ranking, const TileView& view, const DescriptorPlaces& places,
           int tile_idx, uint32_t first_keypoint = 0);

  float Take(const HitRun& run) override;
  // Adds what still waits. Call it after the last hit.
  void Flush();

 private:
  static constexpr size_t kAhead = 16;  // Hits that wait.

  struct Hit {
    uint32_t keypoint_idx = 0;
    uint32_t place = 0;
    float sq_distance = 0.0f;  // With the orientation's term.
  };
  struct Candidate {
    uint32_t keypoint_idx = 0;
    Neighbor neighbor;
  };

  // Works on the hits of the last run.
  void TakeLast();
  // Moves those of them that may be of use to the front; returns their number.
  size_t Keep();
  // Asks for a hit's landmark.
  void Wait(const Hit& hit);
  // Asks for what is known of it.
  void LookUp(const Hit& hit);
  // Adds the position's term and ranks it.
  void Rank(Candidate* candidate);

  LandmarkRanking& ranking_;
  const TileLandmarks& tile_;
  const DescriptorPlaces& places_;
  const int tile_idx_;
  const uint32_t first_keypoint_;
  // Horizontally from the prior to a point of the tile; floats resolve a millimetre.
  Eigen::Matrix<float, 2, 3> prior_from_tile_;
  Eigen::Vector2f tile_in_prior_;
  // The same from a place's CoarseXy.
  Eigen::Matrix2f prior_from_coarse_;
  Eigen::Vector2f coarse_in_prior_;
  float max_free_m_ = 0.0f;  // A coarse place up to so far from the prior may be in view.
  float per_sigma_ = 0.0f;
  // Of the last run; its size and the distances are those of the descriptors.
  std::vector<Hit> last_;
  size_t num_last_ = 0;
  // Rings; the last kAhead of all that came wait.
  std::array<Hit, kAhead> hits_;
  std::array<Candidate, kAhead> candidates_;
  size_t num_hits_ = 0;
  size_t num_candidates_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_LANDMARK_RANKING_H_
