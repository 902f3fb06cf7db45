// What a map tells about photos that were edited after they were taken.
#ifndef CAIRN_MAPPING_SESSION_EDITED_PHOTOS_H_
#define CAIRN_MAPPING_SESSION_EDITED_PHOTOS_H_

#include <span>
#include <string>
#include <vector>

#include "mapping/photo_set.h"
#include "mapping/segment.h"

namespace cairn {

// Returns sentences for people: how many images of the model have another focal length than their
// EXIF said, and how many have their principal point far from the middle. `cameras_as_read` are
// those of the photos before any was corrected; camera i of the model is one of them, modulo their
// number.
std::vector<std::string> NotesOnEditedPhotos(const Reconstruction& model,
                                             std::span<const MappingCamera> cameras_as_read);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_EDITED_PHOTOS_H_
