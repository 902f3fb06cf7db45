// A camera whose focal length, radial distortion and principal point are unknowns. Private to
// core/adjust.
#ifndef CAIRN_CORE_ADJUST_ADJUSTABLE_CAMERA_H_
#define CAIRN_CORE_ADJUST_ADJUSTABLE_CAMERA_H_

#include <Eigen/Core>

#include "core/camera.h"

namespace cairn {

// The unknowns of a camera, in this order: the logarithm of the ratio of the focal lengths to those
// at the start, k1 and k2, and the shift in pixels of the principal point from that at the start.
inline constexpr int kCameraSize = 5;
using CameraUnknowns = Eigen::Matrix<double, kCameraSize, 1>;

class AdjustableCamera {
 public:
  explicit AdjustableCamera(const Camera& camera);

  // True for the models whose distortion is k1, k2, p1 and p2 at most. Others keep theirs, and k1
  // and k2 have no effect.
  bool has_free_distortion() const { return has_free_distortion_; }
  const CameraUnknowns& start() const { return start_; }

  // The Jacobians may be null. False if the point is not in front of the camera or lies outside the
  // field of view in which the distortion is invertible.
  bool Project(const CameraUnknowns& unknowns, const Eigen::Vector3d& x_in_cam,
               Eigen::Vector2d* pixel, Eigen::Matrix<double, 2, 3>* pixel_by_cam,
               Eigen::Matrix<double, 2, kCameraSize>* pixel_by_unknowns) const;

  // The camera with these unknowns, of the same model if that holds them.
  Camera With(const CameraUnknowns& unknowns) const;

 private:
  bool ProjectKept(const CameraUnknowns& unknowns, const Eigen::Vector3d& x_in_cam,
                   Eigen::Vector2d* pixel, Eigen::Matrix<double, 2, 3>* pixel_by_cam,
                   Eigen::Matrix<double, 2, kCameraSize>* pixel_by_unknowns) const;

  Camera camera_;
  bool has_free_distortion_ = false;
  CameraUnknowns start_ = CameraUnknowns::Zero();
  Eigen::Vector2d focal_;   // fx, fy at the start.
  Eigen::Vector2d center_;  // cx, cy at the start.
  double p1_ = 0.0, p2_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_ADJUSTABLE_CAMERA_H_
