// Members that several messages and files share, in both directions. Readers throw JsonError with
// the pointer of the value at fault.
#ifndef CAIRN_CORE_WIRE_JSON_MEMBERS_H_
#define CAIRN_CORE_WIRE_JSON_MEMBERS_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "core/geodesy.h"
#include "core/geoid.h"
#include "core/rig_camera.h"
#include "core/wire/json_reader.h"

namespace cairn {

// Phones report directions rounded and in single precision. This is how far their lengths may be
// from 1.
inline constexpr double kUnitNormTolerance = 0.02;

// Degrees and meters: {"lat", "lon", "h"}.
nlohmann::ordered_json GeodeticJson(const Geodetic& position);
Geodetic ReadGeodetic(const JsonReader& position);
// Without `h` the height is 0.
Geodetic ReadGeodetic(const JsonReader& lat, const JsonReader& lon,
                      const std::optional<JsonReader>& h);

// {"x", "y", "z", "w"}. The reader returns the quaternion as sent; its length differs from 1 by at
// most `tolerance`.
nlohmann::ordered_json QuaternionJson(const Eigen::Quaterniond& rotation);
Eigen::Quaterniond ReadQuaternion(const JsonReader& json, double tolerance = kUnitNormTolerance);

// [x, y, z].
nlohmann::ordered_json VectorJson(const Eigen::Vector3d& vector);
Eigen::Vector3d ReadVector(const JsonReader& json);

// `camera` and `camFromFirst` of an element of `rig`, which may have other members. There are no
// features in either direction.
nlohmann::ordered_json RigCameraJson(const RigCamera& camera);
RigCamera ReadRigCamera(const JsonReader& element);

// Reads "ellipsoid" or "msl".
HeightReference ReadHeightReference(const JsonReader& name);
// Decodes base64, with or without line breaks and padding.
std::vector<uint8_t> ReadBase64(const JsonReader& text);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_JSON_MEMBERS_H_
