#include "core/camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"

namespace cairn {
namespace {

struct ModelInfo {
  CameraModel model;
  const char* name;
  int num_params;
};

constexpr std::array<ModelInfo, 6> kModels = {{
    {CameraModel::kSimplePinhole, "SIMPLE_PINHOLE", 3},
    {CameraModel::kPinhole, "PINHOLE", 4},
    {CameraModel::kSimpleRadial, "SIMPLE_RADIAL", 4},
    {CameraModel::kRadial, "RADIAL", 5},
    {CameraModel::kOpenCv, "OPENCV", 8},
    {CameraModel::kOpenCvFisheye, "OPENCV_FISHEYE", 8},
}};

const ModelInfo& Info(CameraModel model) { return kModels[static_cast<size_t>(model)]; }

constexpr const char* kSupported =
    "supported are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE";

// The smallest positive u at which 1 + a1 u + a2 u^2 + a3 u^3 + a4 u^4 falls to zero, or `max_u`.
double FirstRoot(double a1, double a2, double a3, double a4, double max_u) {
  const auto value = [&](double u) { return 1.0 + u * (a1 + u * (a2 + u * (a3 + u * a4))); };
  constexpr int kNumSteps = 2000;
  double low = 0.0;
  for (int i = 1; i <= kNumSteps; ++i) {
    double high = max_u * i / kNumSteps;
    if (value(high) > 0.0) {
      low = high;
      continue;
    }
    for (int j = 0; j < 60; ++j) {
      const double middle = 0.5 * (low + high);
      (value(middle) > 0.0 ? low : high) = middle;
    }
    return low;
  }
  return max_u;
}

}  // namespace

const char* CameraModelName(CameraModel model) { return Info(model).name; }

CameraModel CameraModelFromName(std::string_view name) {
  for (const ModelInfo& info : kModels) {
    if (name == info.name) {
      return info.model;
    }
  }
  throw Error(ErrorCode::kBadInput, fmt::format("unknown camera model '{}'; {}", name, kSupported));
}

CameraModel CameraModelFromColmapId(int colmap_id) {
  for (const ModelInfo& info : kModels) {
    if (colmap_id == static_cast<int>(info.model)) {
      return info.model;
    }
  }
  throw Error(ErrorCode::kBadInput,
              fmt::format("unsupported COLMAP camera model id {}; {}", colmap_id, kSupported));
}

int NumCameraParams(CameraModel model) { return Info(model).num_params; }

Camera::Camera() : Camera(CameraModel::kPinhole, 640, 480, {500.0, 500.0, 320.0, 240.0}) {}

Camera::Camera(CameraModel model, int width_px, int height_px, std::vector<double> params)
    : model_(model), width_px_(width_px), height_px_(height_px), params_(std::move(params)) {
  constexpr int kMaxSidePx = 100'000;
  if (width_px < 1 || height_px < 1 || width_px > kMaxSidePx || height_px > kMaxSidePx) {
    throw Error(ErrorCode::kBadInput, fmt::format("camera size {} x {} px is not within 1 and {}",
                                                  width_px, height_px, kMaxSidePx));
  }
  if (static_cast<int>(params_.size()) != NumCameraParams(model)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("camera model {} takes {} parameters, not {}", CameraModelName(model),
                            NumCameraParams(model), params_.size()));
  }
  for (size_t i = 0; i < params_.size(); ++i) {
    if (!std::isfinite(params_[i])) {
      throw Error(ErrorCode::kBadInput, fmt::format("camera parameter {} is not finite", i));
    }
  }
  const bool one_focal = model == CameraModel::kSimplePinhole ||
                         model == CameraModel::kSimpleRadial || model == CameraModel::kRadial;
  const size_t next = one_focal ? 1 : 2;
  fx_ = params_[0];
  fy_ = one_focal ? params_[0] : params_[1];
  cx_ = params_[next];
  cy_ = params_[next + 1];
  if (!(fx_ > 0.0) || !(fy_ > 0.0)) {
    throw Error(ErrorCode::kBadInput, "camera focal length must be positive");
  }
  const double* distortion = params_.data() + next + 2;
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
      break;
    case CameraModel::kSimpleRadial:
      k1_ = distortion[0];
      break;
    case CameraModel::kRadial:
      k1_ = distortion[0], k2_ = distortion[1];
      break;
    case CameraModel::kOpenCv:
      k1_ = distortion[0], k2_ = distortion[1], p1_ = distortion[2], p2_ = distortion[3];
      break;
    case CameraModel::kOpenCvFisheye:
      k1_ = distortion[0], k2_ = distortion[1], k3_ = distortion[2], k4_ = distortion[3];
      break;
  }
  // Distortion is inverted only up to where it stops to grow with the radius. 10 is the tangent of
  // 84 degrees off the axis, beyond what a perspective image shows.
  constexpr double kMaxRadius = 10.0;
  max_sq_radius_ = model == CameraModel::kOpenCvFisheye
                       ? FirstRoot(3 * k1_, 5 * k2_, 7 * k3_, 9 * k4_,
                                   0.25 * std::numbers::pi * std::numbers::pi)
                       : FirstRoot(3 * k1_, 5 * k2_, 0.0, 0.0, kMaxRadius * kMaxRadius);
}

Eigen::Vector2d Camera::Distort(const Eigen::Vector2d& normalized,
                                Eigen::Matrix2d* jacobian) const {
  const double u = normalized.x(), v = normalized.y();
  const double sq_radius = u * u + v * v;
  double factor = 1.0;         // Radial scale.
  double d_factor_d_sq = 0.0;  // Its derivative by the squared radius.
  if (model_ == CameraModel::kOpenCvFisheye) {
    const double radius = std::sqrt(sq_radius);
    if (radius > 1e-8) {
      const double theta = std::atan(radius);
      const double t = theta * theta;
      const double theta_d = theta * (1.0 + t * (k1_ + t * (k2_ + t * (k3_ + t * k4_))));
      const double d_theta_d = 1.0 + t * (3 * k1_ + t * (5 * k2_ + t * (7 * k3_ + t * 9 * k4_)));
      factor = theta_d / radius;
      d_factor_d_sq = (d_theta_d / (1.0 + sq_radius) - factor) / (2.0 * sq_radius);
    }
  } else {
    factor = 1.0 + sq_radius * (k1_ + sq_radius * k2_);
    d_factor_d_sq = k1_ + 2.0 * k2_ * sq_radius;
  }
  if (jacobian != nullptr) {
    const double cross = 2.0 * u * v * d_factor_d_sq;
    (*jacobian)(0, 0) = factor + 2.0 * u * u * d_factor_d_sq + 2.0 * p1_ * v + 6.0 * p2_ * u;
    (*jacobian)(0, 1) = cross + 2.0 * p1_ * u + 2.0 * p2_ * v;
    (*jacobian)(1, 0) = cross + 2.0 * p1_ * u + 2.0 * p2_ * v;
    (*jacobian)(1, 1) = factor + 2.0 * v * v * d_factor_d_sq + 6.0 * p1_ * v + 2.0 * p2_ * u;
  }
  return {u * factor + 2.0 * p1_ * u * v + p2_ * (sq_radius + 2.0 * u * u),
          v * factor + p1_ * (sq_radius + 2.0 * v * v) + 2.0 * p2_ * u * v};
}

std::optional<Eigen::Vector2d> Camera::Undistort(const Eigen::Vector2d& distorted) const {
  const bool fisheye = model_ == CameraModel::kOpenCvFisheye;
  Eigen::Vector2d normalized = distorted;
  if (fisheye) {
    // Start from the undistorted angle; the tangent of angles near 90 degrees is no place to start.
    const double theta_d = distorted.norm();
    double theta = std::min(theta_d, std::sqrt(max_sq_radius_));
    for (int i = 0; i < 20; ++i) {
      const double t = theta * theta;
      const double value = theta * (1.0 + t * (k1_ + t * (k2_ + t * (k3_ + t * k4_)))) - theta_d;
      const double slope = 1.0 + t * (3 * k1_ + t * (5 * k2_ + t * (7 * k3_ + t * 9 * k4_)));
      theta -= value / slope;
    }
    constexpr double kMaxThetaRad = 0.5 * std::numbers::pi - 1e-3;
    if (!(theta >= 0.0 && theta < kMaxThetaRad) || theta * theta > max_sq_radius_) {
      return std::nullopt;
    }
    normalized *= theta_d > 1e-8 ? std::tan(theta) / theta_d : 1.0;
  } else if (k1_ != 0.0 || k2_ != 0.0 || p1_ != 0.0 || p2_ != 0.0) {
    for (int i = 0; i < 50; ++i) {
      Eigen::Matrix2d jacobian;
      const Eigen::Vector2d step = Distort(normalized, &jacobian) - distorted;
      if (jacobian.determinant() <= 0.0) {
        return std::nullopt;
      }
      const Eigen::Vector2d delta = jacobian.inverse() * step;
      normalized -= delta;
      if (delta.squaredNorm() < 1e-24) {
        break;
      }
    }
    if (normalized.squaredNorm() > max_sq_radius_) {
      return std::nullopt;
    }
  }
  constexpr double kTolerance = 1e-11;
  if (!((Distort(normalized, nullptr) - distorted).norm() <
        kTolerance * (1.0 + distorted.norm()))) {
    return std::nullopt;
  }
  return normalized;
}

std::optional<Eigen::Vector2d> Camera::Project(const Eigen::Vector3d& x_in_cam) const {
  return ProjectWithJacobian(x_in_cam, nullptr);
}

std::optional<Eigen::Vector2d> Camera::ProjectWithJacobian(
    const Eigen::Vector3d& x_in_cam, Eigen::Matrix<double, 2, 3>* jacobian) const {
  if (!(x_in_cam.z() > 0.0)) {
    return std::nullopt;
  }
  const double inverse_z = 1.0 / x_in_cam.z();
  const Eigen::Vector2d normalized = x_in_cam.head<2>() * inverse_z;
  const double sq_radius = normalized.squaredNorm();
  const double reach = model_ == CameraModel::kOpenCvFisheye
                           ? std::pow(std::atan(std::sqrt(sq_radius)), 2)
                           : sq_radius;
  if (!(reach <= max_sq_radius_)) {
    return std::nullopt;
  }
  Eigen::Matrix2d distort_jacobian;
  const Eigen::Vector2d distorted =
      Distort(normalized, jacobian == nullptr ? nullptr : &distort_jacobian);
  if (jacobian != nullptr) {
    Eigen::Matrix<double, 2, 3> normalize_jacobian;
    normalize_jacobian << inverse_z, 0.0, -normalized.x() * inverse_z,  //
        0.0, inverse_z, -normalized.y() * inverse_z;
    *jacobian = Eigen::Vector2d(fx_, fy_).asDiagonal() * distort_jacobian * normalize_jacobian;
  }
  return Eigen::Vector2d(fx_ * distorted.x() + cx_, fy_ * distorted.y() + cy_);
}

std::optional<Eigen::Vector3d> Camera::Unproject(const Eigen::Vector2d& pixel) const {
  const auto normalized = Undistort({(pixel.x() - cx_) / fx_, (pixel.y() - cy_) / fy_});
  if (!normalized) {
    return std::nullopt;
  }
  return normalized->homogeneous().normalized();
}

bool Camera::Contains(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= width_px_ && pixel.y() <= height_px_;
}

}  // namespace cairn
