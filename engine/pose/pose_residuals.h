// Residuals of a pose and their Jacobians, by which it is refined.
//
// All Jacobians are by (rotation, translation) of the camera in the anchor frame, perturbed on the
// left: anchor_from_cam = (Exp(rotation) R, translation + C), as LocalizeResult::covariance.
#ifndef CAIRN_ENGINE_POSE_POSE_RESIDUALS_H_
#define CAIRN_ENGINE_POSE_POSE_RESIDUALS_H_

#include <Eigen/Core>
#include <optional>

#include "core/camera.h"
#include "core/rigid3.h"

namespace cairn {

using PoseTangent = Eigen::Matrix<double, 6, 1>;

// `anchor_from_cam` moved by a tangent vector.
Rigid3d PerturbPose(const Rigid3d& anchor_from_cam, const PoseTangent& tangent);

// Pixel of the landmark minus the observed pixel; nothing if it does not project. `jacobian` may be
// null.
std::optional<Eigen::Vector2d> ReprojectionResidual(const Camera& camera,
                                                    const Eigen::Vector2d& pixel,
                                                    const Eigen::Vector3d& x_in_anchor,
                                                    const Rigid3d& anchor_from_cam,
                                                    Eigen::Matrix<double, 2, 6>* jacobian);

// Down direction of the pose in the camera frame minus the measured one (a unit vector); for small
// errors its norm is the angle between them. `jacobian` may be null.
Eigen::Vector3d GravityResidual(const Eigen::Vector3d& down_in_cam, const Rigid3d& anchor_from_cam,
                                Eigen::Matrix<double, 3, 6>* jacobian);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_POSE_RESIDUALS_H_
