// Decides which photos of a folder were taken by one camera, and what is known of it.
#ifndef CAIRN_MAPPING_PHOTOS_GROUP_CAMERAS_H_
#define CAIRN_MAPPING_PHOTOS_GROUP_CAMERAS_H_

#include <string>
#include <vector>

#include "core/camera.h"
#include "core/images/exif.h"
#include "mapping/photo_set.h"

namespace cairn {

// What a camera's group is told by.
struct PhotoLens {
  ExifInfo exif;
  bool has_exif = false;
  int width_px = 0, height_px = 0;
};

struct CameraGroups {
  std::vector<MappingCamera> cameras;
  std::vector<int> camera_of_photo;
  std::vector<std::string> notes;  // For people.
};

// Photos share a camera if they have the same size and, by their EXIF, the same kind of camera and
// the same focal length. Photos without a kind and without a focal length share one if at least
// half of the folder has their size: frames of a recording do, a collection from many hands does
// not.
//
// `calibrated` are known cameras. A photo of the size of one of them takes it; of another size with
// the same sides' ratio, it takes the camera scaled; others, and all if there is none, the focal
// length of their EXIF, or else a guess. The EXIF of a photo that was cropped says nothing. A photo
// that is smaller than others of its kind and focal length may be cropped: then its focal length is
// that of its EXIF times the ratio of the sides, and the prior covers both. So may
// one without a kind and without a focal length, unless it is a frame of a recording. Photos that
// may be cropped share no camera, since each may be another part.
//
// A note says if the focal length of a known camera is another than that of the EXIF. Throws
// Error(kBadInput) if its parameters are those of another size of the picture (CameraOfThisSize).
CameraGroups GroupCameras(const std::vector<PhotoLens>& photos,
                          const std::vector<Camera>& calibrated);

}  // namespace cairn

#endif  // CAIRN_MAPPING_PHOTOS_GROUP_CAMERAS_H_
