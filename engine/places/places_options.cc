#include "engine/places/places_options.h"

#include "core/require.h"

namespace cairn {

void PlacesOptions::Validate() const {
  RequireWithin("places.max_descriptors_per_tile", max_descriptors_per_tile, 1, 1'000'000);
  RequireOption(max_bytes > 0, "places.max_bytes must be positive");
  RequireWithin("places.max_neighbors", max_neighbors, 1, 64);
  RequireWithin("places.max_places", max_places, 1, 1'000);
  RequireWithin("places.radius_m", radius_m, 1.0, 1'000.0);
  RequireWithin("places.convincing_confidence", convincing_confidence, 0.0, 1.0);
}

}  // namespace cairn
