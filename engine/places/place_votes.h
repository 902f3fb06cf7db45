// Votes of a photo's descriptors for the places of their neighbors.
#ifndef CAIRN_ENGINE_PLACES_PLACE_VOTES_H_
#define CAIRN_ENGINE_PLACES_PLACE_VOTES_H_

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/geodesy.h"
#include "engine/index/hit_collector.h"
#include "engine/places/place_segment.h"
#include "engine/query/query_context.h"

namespace cairn {

// A place where the photo may have been taken.
struct RankedPlace {
  Geodetic center;  // Height 0.
  double score = 0.0;
};

// The nearest descriptors of each keypoint among all segments that were searched. A keypoint's
// neighbors vote by how much nearer they are than the first descriptor that is no neighbor (McCann
// and Lowe 2012, "Local naive Bayes nearest neighbor"): a descriptor that is everywhere in the map
// says little. Use each object from one thread.
class PlaceVotes : public HitReceiver {
 public:
  // Descriptors farther away than `max_distance` do not vote.
  PlaceVotes(const QueryContext& query, int max_neighbors, double max_distance);

  // The next hits are those of this segment, which must outlive the object.
  void SetSegment(const PlaceSegment* segment) { segment_ = segment; }
  float Take(const HitRun& run) override;
  // Returns the distance of each keypoint beyond which further hits are useless.
  std::vector<double> MaxDistances() const;

  // Returns the places with the most votes, best first, at most `max_places`, no two of them nearer
  // than `min_separation_m`. A place is a cell with the cells around it.
  std::vector<RankedPlace> Best(int max_places, double min_separation_m) const;

 private:
  struct Neighbor {
    float sq_distance = std::numeric_limits<float>::infinity();
    uint32_t row = 0;
    const PlaceSegment* segment = nullptr;
  };

  Neighbor* NeighborsOf(uint32_t keypoint) {
    return neighbors_.data() + static_cast<size_t>(keypoint) * (max_neighbors_ + 1);
  }

  // Whether the orientations may be those of one thing.
  bool MayBeSame(uint32_t keypoint, uint8_t orientation_code) const;
  // The heading of the camera, in steps of kHeadingStep, if the keypoint shows the descriptor; 0
  // without gravity.
  int HeadingOf(size_t keypoint, uint8_t azimuth_code) const;

  const QueryContext& query_;
  int max_neighbors_;
  float max_sq_distance_;
  const PlaceSegment* segment_ = nullptr;
  // max_neighbors + 1 per keypoint, nearest first.
  std::vector<Neighbor> neighbors_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_PLACES_PLACE_VOTES_H_
