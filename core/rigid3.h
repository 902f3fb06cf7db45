// Rigid and similarity transforms of three-dimensional space.
#ifndef CAIRN_CORE_RIGID3_H_
#define CAIRN_CORE_RIGID3_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cairn {

// target_from_source: x_in_target = rotation * x_in_source + translation.
struct Rigid3d {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // Hamilton, unit norm.
  // Origin of the source frame in the target frame, m.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Rigid3d() = default;
  Rigid3d(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : rotation(rotation.normalized()), translation(translation) {}
  Rigid3d(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation)
      : Rigid3d(Eigen::Quaterniond(rotation), translation) {}

  Rigid3d Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation)};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_source) const {
    return rotation * x_in_source + translation;
  }
  Rigid3d operator*(const Rigid3d& source_from_other) const {
    return {rotation * source_from_other.rotation,
            rotation * source_from_other.translation + translation};
  }
  // 3x4 matrix [R | t].
  Eigen::Matrix<double, 3, 4> ToMatrix() const {
    Eigen::Matrix<double, 3, 4> matrix;
    matrix << rotation.toRotationMatrix(), translation;
    return matrix;
  }
};

// target_from_source: x_in_target = scale * rotation * x_in_source + translation.
struct Sim3d {
  double scale = 1.0;  // Positive.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_source) const {
    return scale * (rotation * x_in_source) + translation;
  }
  Sim3d operator*(const Sim3d& source_from_other) const {
    return {scale * source_from_other.scale, (rotation * source_from_other.rotation).normalized(),
            *this * source_from_other.translation};
  }
  Sim3d Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {1.0 / scale, inverse, -(inverse * translation) / scale};
  }
};

inline Sim3d operator*(const Rigid3d& a_from_b, const Sim3d& b_from_c) {
  return {b_from_c.scale, a_from_b.rotation * b_from_c.rotation,
          a_from_b.rotation * b_from_c.translation + a_from_b.translation};
}

// Expresses a pose in the frame to which the similarity maps `world`. Returns cam_from_target in
// the target's metric scale.
inline Rigid3d CamFromTarget(const Rigid3d& cam_from_world, const Sim3d& target_from_world) {
  const Eigen::Quaterniond cam_from_target =
      cam_from_world.rotation * target_from_world.rotation.conjugate();
  const Eigen::Vector3d center_in_world =
      -(cam_from_world.rotation.conjugate() * cam_from_world.translation);
  const Eigen::Vector3d center_in_target = target_from_world * center_in_world;
  return {cam_from_target, -(cam_from_target * center_in_target)};
}

// Converts a rotation vector (axis times angle in radians) to a rotation, and back.
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector);
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& rotation);

// Returns the cross-product matrix: Skew(a) * b == a.cross(b).
Eigen::Matrix3d Skew(const Eigen::Vector3d& a);

// Returns the angle between two rotations, radians in [0, pi].
double RotationAngleRad(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

}  // namespace cairn

#endif  // CAIRN_CORE_RIGID3_H_
