#include "core/adjust/adjustable_camera.h"

#include <cmath>
#include <optional>
#include <vector>

namespace cairn {
namespace {

bool HasPolynomialLens(CameraModel model) {
  return model == CameraModel::kSimplePinhole || model == CameraModel::kPinhole ||
         model == CameraModel::kSimpleRadial || model == CameraModel::kRadial ||
         model == CameraModel::kOpenCv;
}

}  // namespace

AdjustableCamera::AdjustableCamera(const Camera& camera)
    : camera_(camera), has_free_distortion_(HasPolynomialLens(camera.model())) {
  const std::vector<double>& params = camera.params();
  const int num_focal = NumFocalLengths(camera.model());
  focal_ = {params[0], params[num_focal - 1]};
  center_ = {params[num_focal], params[num_focal + 1]};
  if (has_free_distortion_) {
    const size_t at = num_focal + 2;
    const auto term = [&](size_t i) { return at + i < params.size() ? params[at + i] : 0.0; };
    start_.segment<2>(1) << term(0), term(1);
    p1_ = term(2);
    p2_ = term(3);
  }
}

bool AdjustableCamera::ProjectKept(const CameraUnknowns& unknowns, const Eigen::Vector3d& x_in_cam,
                                   Eigen::Vector2d* pixel,
                                   Eigen::Matrix<double, 2, 3>* pixel_by_cam,
                                   Eigen::Matrix<double, 2, kCameraSize>* pixel_by_unknowns) const {
  const std::optional<Eigen::Vector2d> kept = camera_.ProjectWithJacobian(x_in_cam, pixel_by_cam);
  if (!kept) {
    return false;
  }
  const double focal_ratio = std::exp(unknowns[0]);
  const Eigen::Vector2d from_center = focal_ratio * (*kept - center_);
  *pixel = center_ + unknowns.tail<2>() + from_center;
  if (pixel_by_cam != nullptr) {
    *pixel_by_cam *= focal_ratio;
  }
  if (pixel_by_unknowns != nullptr) {
    pixel_by_unknowns->setZero();
    pixel_by_unknowns->col(0) = from_center;
    pixel_by_unknowns->rightCols<2>().setIdentity();
  }
  return true;
}

bool AdjustableCamera::Project(const CameraUnknowns& unknowns, const Eigen::Vector3d& x_in_cam,
                               Eigen::Vector2d* pixel, Eigen::Matrix<double, 2, 3>* pixel_by_cam,
                               Eigen::Matrix<double, 2, kCameraSize>* pixel_by_unknowns) const {
  if (!has_free_distortion_) {
    return ProjectKept(unknowns, x_in_cam, pixel, pixel_by_cam, pixel_by_unknowns);
  }
  if (!(x_in_cam.z() > 0.0)) {
    return false;
  }
  const double k1 = unknowns[1], k2 = unknowns[2];
  const double inverse_z = 1.0 / x_in_cam.z();
  const double u = x_in_cam.x() * inverse_z, v = x_in_cam.y() * inverse_z;
  const double q = u * u + v * v;
  // Core's Lens has the same bound: there, the distorted radius stops growing.
  if (!(1.0 + q * (3.0 * k1 + q * 5.0 * k2) > 0.0)) {
    return false;
  }
  const double radial = 1.0 + q * (k1 + q * k2);
  const Eigen::Vector2d focal = std::exp(unknowns[0]) * focal_;
  const Eigen::Vector2d from_center(
      focal.x() * (u * radial + 2.0 * p1_ * u * v + p2_ * (q + 2.0 * u * u)),
      focal.y() * (v * radial + 2.0 * p2_ * u * v + p1_ * (q + 2.0 * v * v)));
  *pixel = center_ + unknowns.tail<2>() + from_center;
  if (pixel_by_cam != nullptr) {
    const double radial_by_q2 = 2.0 * (k1 + 2.0 * q * k2);
    const double cross = radial_by_q2 * u * v + 2.0 * p1_ * u + 2.0 * p2_ * v;
    Eigen::Matrix2d bent;
    bent << radial + radial_by_q2 * u * u + 2.0 * p1_ * v + 6.0 * p2_ * u, cross,  //
        cross, radial + radial_by_q2 * v * v + 6.0 * p1_ * v + 2.0 * p2_ * u;
    Eigen::Matrix<double, 2, 3> normalized;
    normalized << inverse_z, 0.0, -u * inverse_z, 0.0, inverse_z, -v * inverse_z;
    *pixel_by_cam = focal.asDiagonal() * bent * normalized;
  }
  if (pixel_by_unknowns != nullptr) {
    const Eigen::Vector2d ideal(focal.x() * u, focal.y() * v);
    pixel_by_unknowns->col(0) = from_center;
    pixel_by_unknowns->col(1) = q * ideal;
    pixel_by_unknowns->col(2) = q * q * ideal;
    pixel_by_unknowns->rightCols<2>().setIdentity();
  }
  return true;
}

Camera AdjustableCamera::With(const CameraUnknowns& unknowns) const {
  const double focal_ratio = std::exp(unknowns[0]);
  const int num_focal = NumFocalLengths(camera_.model());
  const Eigen::Vector2d center = center_ + unknowns.tail<2>();
  if (!has_free_distortion_ || unknowns.segment<2>(1) == start_.segment<2>(1)) {
    std::vector<double> params = camera_.params();
    for (int i = 0; i < num_focal; ++i) {
      params[i] *= focal_ratio;
    }
    params[num_focal] = center.x();
    params[num_focal + 1] = center.y();
    return Camera(camera_.model(), camera_.width_px(), camera_.height_px(), std::move(params));
  }
  const Eigen::Vector2d focal = focal_ratio * focal_;
  const double k1 = unknowns[1], k2 = unknowns[2];
  if (camera_.model() == CameraModel::kOpenCv || focal.x() != focal.y()) {
    return Camera(CameraModel::kOpenCv, camera_.width_px(), camera_.height_px(),
                  {focal.x(), focal.y(), center.x(), center.y(), k1, k2, p1_, p2_});
  }
  return Camera(CameraModel::kRadial, camera_.width_px(), camera_.height_px(),
                {focal.x(), center.x(), center.y(), k1, k2});
}

}  // namespace cairn
