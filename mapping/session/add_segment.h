// Makes a segment that has a place part of the model of its session.
#ifndef CAIRN_MAPPING_SESSION_ADD_SEGMENT_H_
#define CAIRN_MAPPING_SESSION_ADD_SEGMENT_H_

#include <span>
#include <vector>

#include "core/rigid3.h"
#include "mapping/photo_set.h"
#include "mapping/segment.h"
#include "mapping/session/map_photos.h"

namespace cairn {

// The cameras of the segment's images. `cameras_as_read` are those of the photo set before any was
// corrected, one for each camera of the segment.
std::vector<CameraReport> ReportCameras(const Segment& segment,
                                        std::span<const MappingCamera> cameras_as_read);

// Appends cameras, images and landmarks of the same world to `model`.
void AppendModel(Reconstruction more, Reconstruction* model);

// Appends the segment to `model`, whose world is that of `mapped`, and reports its images there.
// `number` is the segment's in MappedPhotos::segments. The model may stand apart from `mapped`, as
// it does once it is a session.
void AddSegment(const Segment& segment, const Sim3d& ecef_from_segment, int number,
                MappedPhotos* mapped, Reconstruction* model);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_ADD_SEGMENT_H_
