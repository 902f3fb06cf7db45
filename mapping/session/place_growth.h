// The last stage of a map: segments get their places on Earth and become the model of a session.
#ifndef CAIRN_MAPPING_SESSION_PLACE_GROWTH_H_
#define CAIRN_MAPPING_SESSION_PLACE_GROWTH_H_

#include <span>
#include <string>

#include "core/adjust/adjust.h"
#include "ingest/place/georegister.h"
#include "mapping/growth/grow_segments.h"
#include "mapping/photo_set.h"
#include "mapping/session/map_photos.h"
#include "mapping/session/place_segment.h"
#include "mapping/work_folder.h"

namespace cairn {

// How segments are placed. The members outlive the call.
struct PlaceGrowthOptions {
  const GeoregisterOptions& georegister;
  const AdjustOptions& adjust;
  bool keeps_unplaced = false;       // As MapPhotosInput::keeps_unplaced.
  const WorkFolder* work = nullptr;  // Null: nothing is kept.
  std::string key;                   // Of the results in `work` (PlacementKeyOf).
  MapProgress progress;              // May be empty.
};

struct PlacedGrowth {
  // What MapPhotos returns, but for the stages, the number of photos that were found and those that
  // could not be read.
  MappedPhotos mapped;
  bool is_from_work = false;  // The work folder had all results.
};

// `cameras_as_read` are those of the set before any was corrected. Throws as MapPhotos.
PlacedGrowth PlaceGrowth(const Growth& growth, const PhotoSet& set, const PhotoPlaces& places,
                         std::span<const MappingCamera> cameras_as_read,
                         const PlaceGrowthOptions& options);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_PLACE_GROWTH_H_
