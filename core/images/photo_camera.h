// The camera of a photo, from nothing but its EXIF.
#ifndef CAIRN_CORE_IMAGES_PHOTO_CAMERA_H_
#define CAIRN_CORE_IMAGES_PHOTO_CAMERA_H_

#include "core/camera.h"
#include "core/focal_length.h"
#include "core/images/exif.h"

namespace cairn {

struct PhotoCamera {
  Camera camera;
  FocalPrior focal;
};

// Returns a pinhole camera for a photo of this size, with the 35 mm equivalent focal length of the
// EXIF, which is correct within 5 %. Without such a focal length, returns a camera without any
// known parameter (CameraOfUnknownFocal).
PhotoCamera CameraOfPhoto(const ExifInfo& exif, int width_px, int height_px);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_PHOTO_CAMERA_H_
