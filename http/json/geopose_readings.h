// Converts the sensor readings of a GeoPoseRequest (GeoPoseProtocol 2.0) into parts of a query.
#ifndef CAIRN_HTTP_JSON_GEOPOSE_READINGS_H_
#define CAIRN_HTTP_JSON_GEOPOSE_READINGS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/wire/json_reader.h"
#include "engine/query/localize_query.h"
#include "http/json/request_limits.h"

namespace cairn {

// The pose of a sensor on its rig, from the request's `sensors`.
struct RigPlace {
  std::string rig;  // The rig's name; never empty.
  Rigid3d sensor_from_rig;
};

// Returns the elements of the arrays `readings.member` and `readings.other_spelling`; clients use
// both spellings. Empty if neither array exists.
std::vector<JsonReader> ReadingsOf(const JsonReader& readings, const char* member,
                                   const char* other_spelling);

// The time of a reading in milliseconds since the Unix epoch, if the reading states one.
std::optional<double> TimeOf(const JsonReader& reading);

// Finds the reading's sensor by its id. Returns its place if the request puts the sensor on a rig
// and states its rotation.
std::optional<RigPlace> RigPlaceOf(const JsonReader& request, const JsonReader& reading);

// Returns the position prior of the request, at `time_ms` if known: the geolocation reading nearest
// in time or the prior pose, whichever is more accurate. Readings marked invalid do not count (on
// iOS, a negative accuracy, or latitude and longitude 0).
//
// The protocol takes altitudes from W3C's Geolocation, which measures them from the ellipsoid. iOS
// nevertheless sends heights above mean sea level. A reading can state its reference in the
// extension `altitudeReference` ("ellipsoid" or "msl"). Without a stated reference, the standard
// deviation of the height includes the local height of the geoid.
std::optional<PositionPrior> ReadGeoPosePrior(const JsonReader& request,
                                              std::optional<double> time_ms);

// Returns the down direction in the frame of the picture `camera_reading` as sent, from the
// accelerometer reading nearest in time. Returns nothing
// - without an accelerometer reading,
// - if the device was not at rest (the acceleration differs from gravity by more than 3 %), or
// - if the mounting of camera and accelerometer is unknown. The mounting is known if both are on
//   one rig, or if the picture has an `imageOrientation` and comes from the camera at the back of
//   the device, and the accelerometer uses the device axes of W3C (x right, y up, z out of the
//   screen).
std::optional<Eigen::Vector3d> ReadGeoPoseGravity(const JsonReader& request,
                                                  const JsonReader& camera_reading);

// `imageOrientation.rotation`: the clockwise turn in degrees that makes the picture as sent
// upright, a multiple of 90 in [0, 360). Returns nothing if the reading does not state a rotation.
std::optional<int> ReadRotationDeg(const JsonReader& camera_reading);

// The rotation about the optical axis from the frame of the picture as sent to the frame of the
// upright picture.
Eigen::Quaterniond UprightFromSent(int rotation_deg);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_GEOPOSE_READINGS_H_
