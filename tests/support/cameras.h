// One realistic camera of each model.
#ifndef CAIRN_TESTS_SUPPORT_CAMERAS_H_
#define CAIRN_TESTS_SUPPORT_CAMERAS_H_

#include <vector>

#include "core/camera.h"

namespace cairn::testing {

// VGA cameras. The fisheye camera has a field of view of about 120 degrees.
inline std::vector<Camera> OneCameraPerModel() {
  return {
      Camera(CameraModel::kSimplePinhole, 640, 480, {520, 320, 240}),
      Camera(CameraModel::kPinhole, 640, 480, {500, 510, 325, 236}),
      Camera(CameraModel::kSimpleRadial, 640, 480, {480, 320, 240, -0.12}),
      Camera(CameraModel::kRadial, 640, 480, {480, 320, 240, -0.15, 0.03}),
      Camera(CameraModel::kOpenCv, 640, 480, {490, 495, 318, 243, -0.2, 0.05, 0.001, -0.002}),
      Camera(CameraModel::kOpenCvFisheye, 640, 480,
             {300, 301, 322, 238, -0.02, 0.004, -0.001, 0.0002}),
  };
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_CAMERAS_H_
