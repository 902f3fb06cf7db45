// What the results of stages in the work folder were made from.
#ifndef CAIRN_MAPPING_SESSION_STAGE_KEYS_H_
#define CAIRN_MAPPING_SESSION_STAGE_KEYS_H_

#include <string>

#include "mapping/growth/grow_segments.h"
#include "mapping/photos/read_photos.h"
#include "mapping/session/map_photos.h"
#include "mapping/session/place_segment.h"

namespace cairn {

// What two views, and the cameras that they calibrate, depend on. Its first number changes if a
// stage does.
std::string ViewsKeyOf(const PhotoFolder& folder, const PhotoPlaces& places,
                       const MappingOptions& options);

// What segments depend on. A number of its own changes if only the growth does.
std::string SegmentsKeyOf(const std::string& views_key, const GrowthOptions& options);

// What adjusted segments depend on.
std::string PlacementKeyOf(const std::string& segments_key, const AdjustOptions& adjust,
                           const GeoregisterOptions& georegister);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_STAGE_KEYS_H_
