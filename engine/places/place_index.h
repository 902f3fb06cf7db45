// An index of a map's places by what is seen there.
#ifndef CAIRN_ENGINE_PLACES_PLACE_INDEX_H_
#define CAIRN_ENGINE_PLACES_PLACE_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/stop_function.h"
#include "engine/places/place_segment.h"
#include "engine/places/place_votes.h"
#include "engine/places/places_options.h"
#include "storage/codebook/codebook.h"

namespace cairn {

using SharedSegment = std::shared_ptr<const PlaceSegment>;

// The places of one map version. Immutable; safe to use from any thread.
class PlaceIndex {
 public:
  // All segments belong to the codebook.
  PlaceIndex(std::shared_ptr<const Codebook> codebook, std::vector<SharedSegment> segments)
      : codebook_(std::move(codebook)), segments_(std::move(segments)) {}

  const Codebook& codebook() const { return *codebook_; }
  const std::vector<SharedSegment>& segments() const { return segments_; }
  size_t num_tiles() const;

  // Returns the places that the descriptors (n x dim, projected with the codebook) speak for, best
  // first; see PlaceVotes. Takes time linear in the number of descriptors times segments. Polls
  // `should_stop`; once it returns true, the ranking is that of the segments searched so far.
  std::vector<RankedPlace> Rank(const QueryContext& query, const PlacesOptions& options,
                                const StopFunction& should_stop = {}) const;

  size_t MemoryBytes() const;

 private:
  std::shared_ptr<const Codebook> codebook_;
  std::vector<SharedSegment> segments_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_PLACES_PLACE_INDEX_H_
