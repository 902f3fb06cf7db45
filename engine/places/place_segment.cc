#include "engine/places/place_segment.h"

#include <algorithm>
#include <utility>

#include "engine/index/distance_kernels.h"

namespace cairn {
namespace {

// Lists of 128 descriptors, but at least enough lists that the probes leave most of them out, and
// at most as many as a tile has by default.
int NumListsFor(size_t num_descriptors) {
  constexpr size_t kDescriptorsPerList = 128, kMinLists = 16, kMaxLists = 1024;
  return static_cast<int>(std::clamp(num_descriptors / kDescriptorsPerList, kMinLists, kMaxLists));
}

}  // namespace

PlaceSegment::PlaceSegment(const Codebook& codebook, std::vector<SharedSignature> tiles)
    : tiles_(std::move(tiles)) {
  std::vector<uint8_t> codes;
  std::vector<Place> places;
  for (size_t i = 0; i < tiles_.size(); ++i) {
    codes.insert(codes.end(), tiles_[i]->codes.begin(), tiles_[i]->codes.end());
    for (const PlaceTraits& traits : tiles_[i]->traits) {
      places.push_back({static_cast<uint16_t>(i), traits});
    }
  }
  IndexOptions options;
  options.kind = IndexKind::kInvertedLists;
  options.lists.num_lists = NumListsFor(places.size());
  index_ = MakeMatchingIndex(codebook, codes, options);
  places_.reserve(places.size());
  for (const uint32_t descriptor : index_->order()) {
    places_.push_back(places[descriptor]);
  }
}

size_t PlaceSegment::BytesPerDescriptor(const Codebook& codebook) {
  const size_t stride =
      (codebook.projected_dim() + kDistanceBlock - 1) / kDistanceBlock * kDistanceBlock;
  return stride + 2 * sizeof(uint32_t) + sizeof(Place) + codebook.num_subspaces +
         sizeof(PlaceTraits);
}

}  // namespace cairn
