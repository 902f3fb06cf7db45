#include "core/camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

struct ModelInfo {
  CameraModel model;
  const char* name;
  int num_params;
  int num_focal_lengths;
  bool is_fisheye;
};

// In the order of COLMAP's ids.
constexpr std::array<ModelInfo, 12> kModels = {{
    {CameraModel::kSimplePinhole, "SIMPLE_PINHOLE", 3, 1, false},
    {CameraModel::kPinhole, "PINHOLE", 4, 2, false},
    {CameraModel::kSimpleRadial, "SIMPLE_RADIAL", 4, 1, false},
    {CameraModel::kRadial, "RADIAL", 5, 1, false},
    {CameraModel::kOpenCv, "OPENCV", 8, 2, false},
    {CameraModel::kOpenCvFisheye, "OPENCV_FISHEYE", 8, 2, true},
    {CameraModel::kFullOpenCv, "FULL_OPENCV", 12, 2, false},
    {CameraModel::kFov, "FOV", 5, 2, true},
    {CameraModel::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE", 4, 1, true},
    {CameraModel::kRadialFisheye, "RADIAL_FISHEYE", 5, 1, true},
    {CameraModel::kThinPrismFisheye, "THIN_PRISM_FISHEYE", 12, 2, true},
    {CameraModel::kRadTanThinPrismFisheye, "RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, true},
}};

// COLMAP's later models, which are not supported.
constexpr std::array<const char*, 6> kUnsupported = {
    "SIMPLE_DIVISION", "DIVISION", "SIMPLE_FISHEYE", "FISHEYE", "EUCM", "EQUIRECTANGULAR"};

const ModelInfo& Info(CameraModel model) { return kModels[static_cast<size_t>(model)]; }

std::string SupportedModels() {
  std::string text = "the supported models are";
  for (const ModelInfo& info : kModels) {
    text += fmt::format("{} {}", info.model == kModels.front().model ? "" : ",", info.name);
  }
  return text;
}

// `k` points to the parameters after the principal point.
LensCoefficients CoefficientsOf(CameraModel model, const double* k) {
  LensCoefficients lens;
  if (IsFisheye(model)) {
    lens.projection =
        model == CameraModel::kFov ? LensProjection::kFov : LensProjection::kEquidistant;
  }
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
      break;
    case CameraModel::kSimpleRadial:
    case CameraModel::kSimpleRadialFisheye:
      lens.numerator = {k[0]};
      break;
    case CameraModel::kRadial:
    case CameraModel::kRadialFisheye:
      lens.numerator = {k[0], k[1]};
      break;
    case CameraModel::kOpenCv:
      lens.numerator = {k[0], k[1]};
      lens.p1 = k[2], lens.p2 = k[3];
      break;
    case CameraModel::kOpenCvFisheye:
      lens.numerator = {k[0], k[1], k[2], k[3]};
      break;
    case CameraModel::kFullOpenCv:
      lens.numerator = {k[0], k[1], k[4]};
      lens.denominator = {k[5], k[6], k[7]};
      lens.p1 = k[2], lens.p2 = k[3];
      break;
    case CameraModel::kFov:
      lens.omega_rad = k[0];
      break;
    case CameraModel::kThinPrismFisheye:
      lens.numerator = {k[0], k[1], k[4], k[5]};
      lens.p1 = k[2], lens.p2 = k[3];
      lens.s1 = k[6], lens.s2 = k[7];
      break;
    case CameraModel::kRadTanThinPrismFisheye:
      lens.numerator = {k[0], k[1], k[2], k[3], k[4], k[5]};
      lens.p1 = k[7], lens.p2 = k[6];  // The other way round than in the older models.
      lens.s1 = k[8], lens.s3 = k[9];
      lens.s2 = k[10], lens.s4 = k[11];
      lens.skews_scaled_point = true;
      break;
  }
  return lens;
}

// Throws every error that the constructor of Camera documents.
void CheckCamera(CameraModel model, int width_px, int height_px,
                 const std::vector<double>& params) {
  if (width_px < 1 || height_px < 1 || width_px > Camera::kMaxSidePx ||
      height_px > Camera::kMaxSidePx) {
    throw Error(ErrorCode::kBadInput, fmt::format("camera size {} x {} px is not within 1 and {}",
                                                  width_px, height_px, Camera::kMaxSidePx));
  }
  if (static_cast<int>(params.size()) != NumCameraParams(model)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("camera model {} takes {} parameters, not {}", CameraModelName(model),
                            NumCameraParams(model), params.size()));
  }
  for (size_t i = 0; i < params.size(); ++i) {
    if (!std::isfinite(params[i])) {
      throw Error(ErrorCode::kBadInput, fmt::format("camera parameter {} is not finite", i));
    }
  }
  if (!(params[0] > 0.0) || !(params[NumFocalLengths(model) - 1] > 0.0)) {
    throw Error(ErrorCode::kBadInput, "camera focal length must be positive");
  }
  if (model == CameraModel::kFov && !(std::abs(params[4]) < kPi)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("camera parameter omega is {}, not within pi", params[4]));
  }
}

// Returns the checked parameters, so that members can be initialized from them.
std::vector<double> Checked(CameraModel model, int width_px, int height_px,
                            std::vector<double> params) {
  CheckCamera(model, width_px, height_px, params);
  return params;
}

}  // namespace

const char* CameraModelName(CameraModel model) { return Info(model).name; }

CameraModel CameraModelFromName(std::string_view name) {
  for (const ModelInfo& info : kModels) {
    if (name == info.name) {
      return info.model;
    }
  }
  throw Error(ErrorCode::kBadInput, fmt::format("camera model '{}' is not supported; {}",
                                                Excerpt(name), SupportedModels()));
}

CameraModel CameraModelFromColmapId(int colmap_id) {
  if (colmap_id >= 0 && colmap_id < static_cast<int>(kModels.size())) {
    return kModels[colmap_id].model;
  }
  const int64_t past = int64_t{colmap_id} - static_cast<int64_t>(kModels.size());
  const bool has_name = past >= 0 && past < static_cast<int64_t>(kUnsupported.size());
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("COLMAP's camera model {}{} is not supported; {}", colmap_id,
                  has_name ? fmt::format(" ({})", kUnsupported[past]) : "", SupportedModels()));
}

int NumCameraParams(CameraModel model) { return Info(model).num_params; }
int NumFocalLengths(CameraModel model) { return Info(model).num_focal_lengths; }
bool IsFisheye(CameraModel model) { return Info(model).is_fisheye; }

Camera::Camera() : Camera(CameraModel::kPinhole, 640, 480, {500.0, 500.0, 320.0, 240.0}) {}

Camera::Camera(CameraModel model, int width_px, int height_px, std::vector<double> params)
    : model_(model),
      width_px_(width_px),
      height_px_(height_px),
      params_(Checked(model, width_px, height_px, std::move(params))),
      fx_(params_[0]),
      fy_(params_[NumFocalLengths(model) - 1]),
      cx_(params_[NumFocalLengths(model)]),
      cy_(params_[NumFocalLengths(model) + 1]),
      lens_(CoefficientsOf(model, params_.data() + NumFocalLengths(model) + 2)) {}

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
  Eigen::Matrix2d distort_jacobian;
  const std::optional<Eigen::Vector2d> distorted =
      lens_.Distort(normalized, jacobian == nullptr ? nullptr : &distort_jacobian);
  if (!distorted) {
    return std::nullopt;
  }
  if (jacobian != nullptr) {
    Eigen::Matrix<double, 2, 3> normalize_jacobian;
    normalize_jacobian << inverse_z, 0.0, -normalized.x() * inverse_z,  //
        0.0, inverse_z, -normalized.y() * inverse_z;
    *jacobian = Eigen::Vector2d(fx_, fy_).asDiagonal() * distort_jacobian * normalize_jacobian;
  }
  return Eigen::Vector2d(fx_ * distorted->x() + cx_, fy_ * distorted->y() + cy_);
}

std::optional<Eigen::Vector3d> Camera::Unproject(const Eigen::Vector2d& pixel) const {
  const auto normalized = lens_.Undistort({(pixel.x() - cx_) / fx_, (pixel.y() - cy_) / fy_});
  if (!normalized) {
    return std::nullopt;
  }
  return normalized->homogeneous().normalized();
}

bool Camera::Contains(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= width_px_ && pixel.y() <= height_px_;
}

}  // namespace cairn
