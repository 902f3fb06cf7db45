#include "core/wire/json_members.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/wire/base64.h"
#include "core/wire/stated_camera.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

Json CamFromFirstJson(const Rigid3d& cam_from_first) {
  return {{"quaternion", QuaternionJson(cam_from_first.rotation)},
          {"translation", VectorJson(cam_from_first.translation)}};
}

Rigid3d ReadCamFromFirst(const JsonReader& json) {
  json.RequireOnly({"quaternion", "translation"});
  const JsonReader quaternion = json.At("quaternion");
  quaternion.RequireOnly({"x", "y", "z", "w"});
  const Eigen::Quaterniond rotation = ReadQuaternion(quaternion);
  const JsonReader translation = json.At("translation");
  const Eigen::Vector3d offset = ReadVector(translation);
  if (!(offset.norm() <= RigCamera::kMaxOffsetM)) {
    translation.Fail(fmt::format("is longer than {} m", RigCamera::kMaxOffsetM));
  }
  return {rotation, offset};
}

}  // namespace

Json GeodeticJson(const Geodetic& position) {
  return {{"lat", position.lat_deg()}, {"lon", position.lon_deg()}, {"h", position.h_m}};
}

Geodetic ReadGeodetic(const JsonReader& position) {
  return ReadGeodetic(position.At("lat"), position.At("lon"), position.At("h"));
}

Geodetic ReadGeodetic(const JsonReader& lat, const JsonReader& lon,
                      const std::optional<JsonReader>& h) {
  return Geodetic::FromDegrees(lat.Number(-90.0, 90.0), lon.Number(-180.0, 180.0),
                               h ? h->Number(Geodetic::kMinHeightM, Geodetic::kMaxHeightM) : 0.0);
}

Json QuaternionJson(const Eigen::Quaterniond& rotation) {
  return {{"x", rotation.x()}, {"y", rotation.y()}, {"z", rotation.z()}, {"w", rotation.w()}};
}

Eigen::Quaterniond ReadQuaternion(const JsonReader& json, double tolerance) {
  const auto component = [&](const char* name) { return json.At(name).Number(); };
  const Eigen::Quaterniond rotation(component("w"), component("x"), component("y"), component("z"));
  if (!(std::abs(rotation.norm() - 1.0) <= tolerance)) {
    json.Fail(fmt::format("has length {}, not 1", rotation.norm()));
  }
  return rotation;
}

Json VectorJson(const Eigen::Vector3d& vector) {
  return Json::array({vector.x(), vector.y(), vector.z()});
}

Eigen::Vector3d ReadVector(const JsonReader& json) {
  const std::vector<double> numbers = json.Numbers(3, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

Json RigCameraJson(const RigCamera& camera) {
  return {{"camera", CameraJson(camera.camera)},
          {"camFromFirst", CamFromFirstJson(camera.cam_from_first)}};
}

RigCamera ReadRigCamera(const JsonReader& element) {
  RigCamera camera;
  camera.camera = ReadKnownCamera(element.At("camera"));
  camera.cam_from_first = ReadCamFromFirst(element.At("camFromFirst"));
  return camera;
}

HeightReference ReadHeightReference(const JsonReader& name) {
  const std::optional<HeightReference> reference = HeightReferenceFromName(name.String());
  if (!reference) {
    name.Fail("is unknown", "known: ellipsoid, msl (mean sea level)");
  }
  return *reference;
}

std::vector<uint8_t> ReadBase64(const JsonReader& text) {
  std::optional<std::vector<uint8_t>> bytes = DecodeBase64OfClient(text.String());
  if (!bytes) {
    text.Fail("is not base64",
              "use the standard alphabet (RFC 4648 section 4), and no prefix such as data:");
  }
  return std::move(*bytes);
}

}  // namespace cairn
