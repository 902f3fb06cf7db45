#include "engine/places/place_index.h"

#include "storage/codebook/distance_statistics.h"

namespace cairn {

size_t PlaceIndex::num_tiles() const {
  size_t num_tiles = 0;
  for (const SharedSegment& segment : segments_) {
    num_tiles += segment->tiles().size();
  }
  return num_tiles;
}

std::vector<RankedPlace> PlaceIndex::Rank(const QueryContext& query, const PlacesOptions& options,
                                          const StopFunction& should_stop) const {
  constexpr double kQuantile = 0.9;  // As matching uses, MatchingOptions::distance_quantile.
  const double max_distance = SameLandmarkDistance(*codebook_, kQuantile);
  PlaceVotes votes(query, options.max_neighbors, max_distance);
  for (const SharedSegment& segment : segments_) {
    const std::vector<double> max_distances = votes.MaxDistances();
    votes.SetSegment(segment.get());
    segment->index().Search({.queries = query.descriptors,
                             .max_distances = max_distances,
                             .receiver = &votes,
                             .should_stop = should_stop},
                            nullptr);
  }
  return votes.Best(options.max_places, options.radius_m);
}

size_t PlaceIndex::MemoryBytes() const {
  size_t num_bytes = sizeof(*this);
  for (const SharedSegment& segment : segments_) {
    num_bytes += segment->MemoryBytes();
    for (const SharedSignature& tile : segment->tiles()) {
      num_bytes += tile->MemoryBytes();
    }
  }
  return num_bytes;
}

}  // namespace cairn
