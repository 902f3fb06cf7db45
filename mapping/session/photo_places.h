// Where the photos of a set were taken, by their EXIF or by a table.
#ifndef CAIRN_MAPPING_SESSION_PHOTO_PLACES_H_
#define CAIRN_MAPPING_SESSION_PHOTO_PLACES_H_

#include <set>
#include <string>
#include <vector>

#include "mapping/photos/read_photos.h"
#include "mapping/session/map_photos.h"

namespace cairn {

// The names of the photos in `input.paths` that its table of positions has; none without a table.
// Throws as ReadPositionsOfPhotos.
std::set<std::string> NamesInTable(const MapPhotosInput& input);

// Positions of a table replace those of the set, too, for the stages that compare distances; for
// these, a photo whose EXIF states no accuracy has none. Adds sentences to `notes`. Throws
// Error(kBadInput), with what to do, if fewer than three photos have a position, if the table has
// latitude and longitude exchanged by the EXIF of the photos, and as ReadCameraPositions and
// CheckPositions do.
PhotoPlaces FindPhotoPlaces(const MapPhotosInput& input, PhotoFolder* folder,
                            std::vector<std::string>* notes);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_PHOTO_PLACES_H_
