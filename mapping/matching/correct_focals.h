// Focal lengths of EXIF that the photos contradict.
#ifndef CAIRN_MAPPING_MATCHING_CORRECT_FOCALS_H_
#define CAIRN_MAPPING_MATCHING_CORRECT_FOCALS_H_

#include <optional>
#include <span>
#include <vector>

#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn {

// Returns nothing if no focal length is wrong, else the cameras of the set. Where the source was
// kExif, and the two views of the camera's photos agree that its focal length is wrong by a fifth
// or more, the camera has the one that they tell, the source kPhotos, and the standard deviation
// found. Programs that crop or enlarge a photo leave the focal length of the whole picture in its
// EXIF. One camera is corrected at a time, the surest first, and then its partners are judged
// again; two views with a camera that is a guess do not count. Time: about 20 two views a camera,
// and as many for each that is corrected. Deterministic; the result does not depend on the number
// of threads.
std::optional<std::vector<MappingCamera>> CorrectFocals(const PhotoSet& set,
                                                        std::span<const TwoView> views,
                                                        int num_threads);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_CORRECT_FOCALS_H_
