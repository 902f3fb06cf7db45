// The camera of a photo that says no more than its EXIF.
#ifndef CAIRN_INGEST_IMAGES_PHOTO_CAMERA_H_
#define CAIRN_INGEST_IMAGES_PHOTO_CAMERA_H_

#include "core/camera.h"
#include "core/focal_length.h"
#include "ingest/images/exif.h"

namespace cairn {

struct PhotoCamera {
  Camera camera;
  FocalPrior focal;
};

// Of a photo of this size: a pinhole with the 35 mm equivalent focal length of its EXIF, right
// within 5 %; without one, a camera of which nothing is known (CameraOfUnknownFocal).
PhotoCamera CameraOfPhoto(const ExifInfo& exif, int width_px, int height_px);

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_PHOTO_CAMERA_H_
