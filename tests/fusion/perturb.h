// Perturbations of poses, as FilterState makes them.
#ifndef CAIRN_TESTS_FUSION_PERTURB_H_
#define CAIRN_TESTS_FUSION_PERTURB_H_

#include <Eigen/Core>

#include "core/rigid3.h"

namespace cairn::fusion::testing {

using Vector6d = Eigen::Matrix<double, 6, 1>;

// By [theta, p] of a pose in local.
inline Rigid3d PerturbLeft(const Rigid3d& pose, const Vector6d& error) {
  Rigid3d moved = pose;
  moved.rotation = ExpSo3(error.head<3>()) * pose.rotation;
  moved.translation += error.tail<3>();
  return moved;
}

// By [rho, psi, tilt] of global_from_local.
inline Rigid3d PerturbGlobal(const Rigid3d& global_from_local, const Vector6d& error) {
  return global_from_local * Rigid3d(ExpSo3({error[4], error[5], error[3]}), error.head<3>());
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_PERTURB_H_
