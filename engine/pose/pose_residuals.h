// Residuals of a pose and their Jacobians, for refinement.
//
// All Jacobians are with respect to (rotation, translation) of the camera in the anchor frame,
// perturbed on the left: anchor_from_cam = (Exp(rotation) R, translation + C), as in
// LocalizeResult::covariance.
#ifndef CAIRN_ENGINE_POSE_POSE_RESIDUALS_H_
#define CAIRN_ENGINE_POSE_POSE_RESIDUALS_H_

#include <Eigen/Core>
#include <optional>

#include "core/camera.h"
#include "core/rigid3.h"
#include "engine/query/landmark_shape.h"

namespace cairn {

using PoseTangent = Eigen::Matrix<double, 6, 1>;

// Returns `anchor_from_cam` moved by a tangent vector.
Rigid3d PerturbPose(const Rigid3d& anchor_from_cam, const PoseTangent& tangent);

// A camera at a pose, prepared for many projections.
struct PosedCamera {
  PosedCamera(const Camera& camera_in, const Rigid3d& anchor_from_cam)
      : camera(&camera_in),
        cam_from_anchor(anchor_from_cam.rotation.conjugate().toRotationMatrix()),
        center_in_anchor(anchor_from_cam.translation) {}

  const Camera* camera;  // Must outlive this.
  Eigen::Matrix3d cam_from_anchor;
  Eigen::Vector3d center_in_anchor;
};

// Returns the pixel of a landmark and its derivative with respect to the landmark; nothing if the
// landmark does not project.
inline std::optional<Eigen::Vector2d> ProjectLandmark(
    const PosedCamera& camera, const Eigen::Vector3d& x_in_anchor,
    Eigen::Matrix<double, 2, 3>* pixel_by_anchor) {
  Eigen::Matrix<double, 2, 3> pixel_by_cam;
  const std::optional<Eigen::Vector2d> pixel = camera.camera->ProjectWithJacobian(
      camera.cam_from_anchor * (x_in_anchor - camera.center_in_anchor), &pixel_by_cam);
  if (pixel) {
    pixel_by_anchor->noalias() = pixel_by_cam * camera.cam_from_anchor;
  }
  return pixel;
}

// The error of a reprojection, as the landmark's error and the keypoint's make it.
struct ErrorShape {
  // W with W'W = s^2 (s^2 I + A P A')^-1, for a landmark whose position has the covariance P and a
  // keypoint with the standard deviation s per axis. W times the error has the standard deviation
  // s along every axis.
  Eigen::Matrix2d whitening;
  // W times what LandmarkShape::by_distance_m moves the pixel, pixels.
  Eigen::Vector2d by_distance_px;
};

// Nothing if the landmark does not project. The shape changes little while a pose is refined, so it
// is found once, at the initial pose.
std::optional<ErrorShape> ErrorShapeAt(const PosedCamera& camera,
                                       const Eigen::Vector3d& x_in_anchor,
                                       const LandmarkShape& shape_in_anchor,
                                       double keypoint_sigma_px);

// Returns the Jacobian of the pixel with respect to the pose of a rig, which rotates about a
// center. `from_center` is the vector from that center to the landmark, anchor frame.
inline Eigen::Matrix<double, 2, 6> ReprojectionJacobian(
    const Eigen::Matrix<double, 2, 3>& pixel_by_anchor, const Eigen::Vector3d& from_center) {
  // x_in_cam = R' Exp(-rotation) (x - C - translation).
  Eigen::Matrix<double, 2, 6> jacobian;
  jacobian << pixel_by_anchor * Skew(from_center), -pixel_by_anchor;
  return jacobian;
}

// Returns the pose's down direction in the camera frame minus the measured one (a unit vector). For
// small errors, its norm is the angle between the two. `jacobian` may be null.
Eigen::Vector3d GravityResidual(const Eigen::Vector3d& down_in_cam, const Rigid3d& anchor_from_cam,
                                Eigen::Matrix<double, 3, 6>* jacobian);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_POSE_RESIDUALS_H_
