#include "http/json/request_members.h"

#include <fmt/format.h>

#include <cmath>

#include "core/wire/base64.h"
#include "http/json/stated_camera.h"

namespace cairn {
namespace {

Rigid3d ReadCamFromFirst(const JsonReader& json) {
  json.RequireOnly({"quaternion", "translation"});
  const JsonReader quaternion = json.At("quaternion");
  quaternion.RequireOnly({"x", "y", "z", "w"});
  const auto component = [&](const char* name) { return quaternion.At(name).Number(-1.01, 1.01); };
  const Eigen::Quaterniond rotation(component("w"), component("x"), component("y"), component("z"));
  if (!(std::abs(rotation.norm() - 1.0) <= kUnitNormTolerance)) {
    quaternion.Fail(fmt::format("has length {}, not 1", rotation.norm()));
  }
  const JsonReader translation = json.At("translation");
  const std::vector<double> numbers = translation.Numbers(3, 3);
  const Eigen::Vector3d offset(numbers[0], numbers[1], numbers[2]);
  if (!(offset.norm() <= RigCamera::kMaxOffsetM)) {
    translation.Fail(fmt::format("is longer than {} m", RigCamera::kMaxOffsetM));
  }
  return {rotation, offset};
}

}  // namespace

HeightReference ReadHeightReference(const JsonReader& name) {
  const std::optional<HeightReference> reference = HeightReferenceFromName(name.String());
  if (!reference) {
    name.Fail("is unknown", "known: ellipsoid, msl (mean sea level)");
  }
  return *reference;
}

RigCamera ReadRigCamera(const JsonReader& element) {
  RigCamera camera;
  camera.camera = ReadKnownCamera(element.At("camera"));
  camera.cam_from_first = ReadCamFromFirst(element.At("camFromFirst"));
  return camera;
}

std::vector<uint8_t> ReadBase64(const JsonReader& text) {
  std::optional<std::vector<uint8_t>> bytes = DecodeBase64OfClient(text.String());
  if (!bytes) {
    text.Fail("is not base64",
              "use the standard alphabet (RFC 4648 section 4), and no prefix such as data:");
  }
  return std::move(*bytes);
}

Geodetic ReadGeodetic(const JsonReader& lat, const JsonReader& lon,
                      const std::optional<JsonReader>& h) {
  return Geodetic::FromDegrees(lat.Number(-90.0, 90.0), lon.Number(-180.0, 180.0),
                               h ? h->Number(Geodetic::kMinHeightM, Geodetic::kMaxHeightM) : 0.0);
}

}  // namespace cairn
