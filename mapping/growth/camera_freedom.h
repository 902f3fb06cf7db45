// How much a camera of a set may change in an adjustment.
#ifndef CAIRN_MAPPING_GROWTH_CAMERA_FREEDOM_H_
#define CAIRN_MAPPING_GROWTH_CAMERA_FREEDOM_H_

#include "core/adjust/adjust.h"
#include "mapping/photo_set.h"

namespace cairn {

// Photos of one camera from which the focal length of EXIF can be improved and the distortion be
// told apart from it. A few photos along one line determine neither.
inline constexpr int kMinPhotosToCalibrate = 10;

// The freedom of a camera that `num_photos` photos of the adjusted model have. Given intrinsics
// stay. If a picture may be cropped, its focal length, distortion and principal point are always
// adjusted. A focal length of EXIF is adjusted only if `is_final` and kMinPhotosToCalibrate photos
// have the camera, then with the distortion. A focal length that is a guess, or told by the photos,
// is always adjusted, and if `is_final` with the distortion: photos that nobody knows anything
// about were taken by many cameras, and what bends one picture would bend the scene.
inline CameraFreedom FreedomOf(const MappingCamera& camera, int num_photos, bool is_final) {
  if (camera.source == FocalSource::kCalibration || num_photos == 0) {
    return CameraFreedom::kFixed;
  }
  if (camera.may_be_cropped) {
    return CameraFreedom::kWithPrincipalPoint;
  }
  if (is_final && num_photos >= kMinPhotosToCalibrate) {
    return CameraFreedom::kFocalAndDistortion;
  }
  if (camera.source == FocalSource::kExif) {
    return CameraFreedom::kFixed;
  }
  return is_final ? CameraFreedom::kFocalAndDistortion : CameraFreedom::kFocal;
}

// True if the growth of a segment put the camera back to the focal length of its EXIF and held it,
// or never adjusted it: an adjustment does not return to the same number.
inline bool HasFocalOfExif(const MappingCamera& known, const Camera& grown) {
  return known.source == FocalSource::kExif && grown.focal_px() == known.camera.focal_px();
}

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_CAMERA_FREEDOM_H_
