#include "core/wire/inner_frame.h"

#include <array>
#include <utility>

namespace cairn {
namespace {

constexpr std::array<std::pair<InnerFrame, const char*>, 4> kNames = {{
    {InnerFrame::kFlu, "FLU"},
    {InnerFrame::kRdf, "RDF"},
    {InnerFrame::kRub, "RUB"},
    {InnerFrame::kEus, "EUS"},
}};

}  // namespace

const char* InnerFrameName(InnerFrame frame) {
  return kNames.at(static_cast<size_t>(frame)).second;
}

std::optional<InnerFrame> InnerFrameFromName(std::string_view name) {
  for (const auto& [frame, frame_name] : kNames) {
    if (name == frame_name) {
      return frame;
    }
  }
  return std::nullopt;
}

Eigen::Matrix3d CamFromInner(InnerFrame frame) {
  Eigen::Matrix3d cam_from_inner;
  switch (frame) {
    case InnerFrame::kFlu:
      cam_from_inner.col(0) = Eigen::Vector3d::UnitZ();
      cam_from_inner.col(1) = -Eigen::Vector3d::UnitX();
      cam_from_inner.col(2) = -Eigen::Vector3d::UnitY();
      break;
    case InnerFrame::kRdf:
      cam_from_inner.setIdentity();
      break;
    case InnerFrame::kRub:
    case InnerFrame::kEus:
      cam_from_inner = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
      break;
  }
  return cam_from_inner;
}

GeoPose GeoPoseFromCamera(const Rigid3d& cam_from_ecef, InnerFrame frame) {
  const Rigid3d ecef_from_cam = cam_from_ecef.Inverse();
  GeoPose geopose;
  geopose.position = GeodeticFromEcef(ecef_from_cam.translation);
  const Eigen::Quaterniond enu_from_ecef = EcefFromEnu(geopose.position).rotation.conjugate();
  geopose.enu_from_inner =
      (enu_from_ecef * ecef_from_cam.rotation * Eigen::Quaterniond(CamFromInner(frame)))
          .normalized();
  if (geopose.enu_from_inner.w() < 0.0) {
    geopose.enu_from_inner.coeffs() *= -1.0;
  }
  return geopose;
}

Rigid3d CameraFromGeoPose(const GeoPose& geopose, InnerFrame frame) {
  const Rigid3d ecef_from_enu = EcefFromEnu(geopose.position);
  const Eigen::Quaterniond inner_from_cam(CamFromInner(frame).transpose());
  return Rigid3d(ecef_from_enu.rotation * geopose.enu_from_inner * inner_from_cam,
                 EcefFromGeodetic(geopose.position))
      .Inverse();
}

}  // namespace cairn
