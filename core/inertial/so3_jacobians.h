// Derivatives of the exponential map of rotations.
#ifndef CAIRN_CORE_INERTIAL_SO3_JACOBIANS_H_
#define CAIRN_CORE_INERTIAL_SO3_JACOBIANS_H_

#include <Eigen/Core>

namespace cairn::fusion {

// The J with Exp(x + d) = Exp(J d) Exp(x) to first order in d. Its transpose is the right Jacobian.
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& rotation_vector);

// The inverse of J: Log(Exp(d) Exp(x)) = x + J^-1 d to first order. Valid for angles below 2 pi.
Eigen::Matrix3d InverseLeftJacobian(const Eigen::Vector3d& rotation_vector);

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_INERTIAL_SO3_JACOBIANS_H_
