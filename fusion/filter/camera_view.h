// Predicts the pixel of a point seen by the camera at a past pose of the IMU, with the derivatives
// by the state.
//
// Symbols, as in docs/math/fusion.md: A is the rotation of cam_from_local; x is a point in local;
// p^ is the first estimate of the pose's position; D = d pixel / d x = J A with J = d pixel / d
// (point in cam).
#ifndef CAIRN_FUSION_FILTER_CAMERA_VIEW_H_
#define CAIRN_FUSION_FILTER_CAMERA_VIEW_H_

#include <Eigen/Core>
#include <optional>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

// The camera at one pose, prepared for projection.
struct CameraView {
  CameraView(const Rig& rig, const Clone& clone);

  Eigen::Matrix3d cam_from_local_rotation;
  Eigen::Vector3d center_in_local;
  Eigen::Vector3d first_position_in_local;  // Position of the IMU.

  Eigen::Vector3d ToCam(const Eigen::Vector3d& x_in_local) const {
    return cam_from_local_rotation * (x_in_local - center_in_local);
  }
};

struct PredictedPixel {
  Eigen::Vector2d pixel;
  Eigen::Vector3d x_in_cam;
  Eigen::Matrix<double, 2, 3> by_cam;    // J.
  Eigen::Matrix<double, 2, 3> by_local;  // D.
};

// Returns nullopt if the point does not project or is nearer than 5 cm.
std::optional<PredictedPixel> PredictPixel(const Camera& camera, const CameraView& view,
                                           const Eigen::Vector3d& x_in_local);

// Derivative by the error [theta, p] of the clone: [D [x - p^]x, -D].
Eigen::Matrix<double, 2, kCloneDim> ByClone(const PredictedPixel& predicted, const CameraView& view,
                                            const Eigen::Vector3d& x_in_local);

// Derivative by the error [rho, psi, tilt] of global_from_local, for a landmark that is fixed in
// global and has the position x in local: -D by rho, and D [x]x by the rotation, whose z column
// comes first.
Eigen::Matrix<double, 2, kGlobalDim> ByGlobal(const PredictedPixel& predicted,
                                              const Eigen::Vector3d& x_in_local);

// Derivative by the error [phi, p, time offset] of the rig: [-J [x_cam - p]x, J, 0]. The time
// offset acts through the clone.
Eigen::Matrix<double, 2, kRigDim> ByRig(const PredictedPixel& predicted, const Rig& rig);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_CAMERA_VIEW_H_
