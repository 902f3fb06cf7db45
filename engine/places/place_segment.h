// The signatures of neighboring tiles, searchable. A part of a PlaceIndex.
#ifndef CAIRN_ENGINE_PLACES_PLACE_SEGMENT_H_
#define CAIRN_ENGINE_PLACES_PLACE_SEGMENT_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/index/matching_index.h"
#include "engine/places/tile_signature.h"
#include "storage/codebook/codebook.h"

namespace cairn {

using SharedSignature = std::shared_ptr<const TileSignature>;

// Immutable; safe to use from any thread.
class PlaceSegment {
 public:
  // All tiles must be coded with the codebook; there are at most 65,536 tiles. Takes time linear in
  // the number of descriptors.
  PlaceSegment(const Codebook& codebook, std::vector<SharedSignature> tiles);

  const std::vector<SharedSignature>& tiles() const { return tiles_; }
  size_t num_descriptors() const { return places_.size(); }
  const MatchingIndex& index() const { return *index_; }
  // The tile and the traits of the descriptor in a row of the index (MatchingIndex::order).
  TileId TileAt(uint32_t row) const { return tiles_[places_[row].tile_idx]->id; }
  const PlaceTraits& TraitsAt(uint32_t row) const { return places_[row].traits; }

  size_t MemoryBytes() const {
    return sizeof(*this) + places_.capacity() * sizeof(Place) + index_->MemoryBytes();
  }
  // Of a descriptor in a segment and in its signature: a byte per dimension with norm and number in
  // the index, the place, and code and traits.
  static size_t BytesPerDescriptor(const Codebook& codebook);

 private:
  struct Place {
    uint16_t tile_idx = 0;
    PlaceTraits traits;
  };

  std::vector<SharedSignature> tiles_;
  std::unique_ptr<const MatchingIndex> index_;
  std::vector<Place> places_;  // By row of the index.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_PLACES_PLACE_SEGMENT_H_
