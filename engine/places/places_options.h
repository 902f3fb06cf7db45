// Options of the search for places, which answers queries without a prior.
#ifndef CAIRN_ENGINE_PLACES_PLACES_OPTIONS_H_
#define CAIRN_ENGINE_PLACES_PLACES_OPTIONS_H_

#include <cstdint>

namespace cairn {

struct PlacesOptions {
  // Descriptors of a tile in the index, at most. A photo shows a few per cent of what is around it,
  // so a map loses places with each half of its descriptors.
  int max_descriptors_per_tile = 16'384;
  // Bound on the memory of the index. If the tiles of a map exceed the bound, each tile has fewer
  // descriptors: half as many, a quarter, and so on.
  uint64_t max_bytes = uint64_t{512} << 20;
  // Neighbors of a keypoint's descriptor in the index that vote, 1 to 64.
  int max_neighbors = 10;
  // Number of places that are searched, the best first; 1 to 1000.
  int max_places = 8;
  // Distance around the middle of a place within which the camera is sought, meters.
  double radius_m = 75.0;
  // The search ends with the first answer of at least this confidence, [0, 1].
  double convincing_confidence = 0.98;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_PLACES_PLACES_OPTIONS_H_
