// The sensor readings of a GeoPoseRequest (GeoPoseProtocol 2.0), each as a query wants it.
#ifndef CAIRN_HTTP_JSON_GEOPOSE_READINGS_H_
#define CAIRN_HTTP_JSON_GEOPOSE_READINGS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "engine/query/localize_query.h"
#include "http/json/json_reader.h"

namespace cairn {

// A sensor's place on its rig, of `sensors`.
struct RigPlace {
  std::string rig;  // Its name; never empty.
  Rigid3d sensor_from_rig;
};

// The element of `readings.member` for each of the two spellings that clients use; empty if there
// is none.
std::vector<JsonReader> ReadingsOf(const JsonReader& readings, const char* member,
                                   const char* other_spelling);

// When a reading was taken, milliseconds since the Unix epoch, if it says.
std::optional<double> TimeOf(const JsonReader& reading);

// The sensor that made a reading, by its id, if the request places it on a rig with a rotation.
std::optional<RigPlace> RigPlaceOf(const JsonReader& request, const JsonReader& reading);

// Where the request says it was made, at `time_ms` if that is known: the geolocation reading
// nearest in time, or the prior pose, whichever is known better. Readings that say that they are
// invalid (iOS: by a negative accuracy; latitude and longitude 0) do not count.
//
// Altitudes are above the ellipsoid, as the protocol takes them from W3C's Geolocation. Since iOS
// sends heights above mean sea level all the same, the standard deviation of one that does not say
// what it is (`altitudeReference`, an extension: "ellipsoid" or "msl") includes the height of the
// geoid there.
std::optional<PositionPrior> ReadGeoPosePrior(const JsonReader& request,
                                              std::optional<double> time_ms);

// Down in the frame of the picture `camera_reading` as it was sent, by the accelerometer reading
// nearest in time; nothing without one, if the device was not at rest (the acceleration is not that
// of gravity within 3 %), or if it is not known how camera and accelerometer are mounted: both on
// one rig, or the picture from the camera at the device's back with its `imageOrientation`, and the
// accelerometer in the device's axes as W3C has them (x right, y up, z out of the screen).
std::optional<Eigen::Vector3d> ReadGeoPoseGravity(const JsonReader& request,
                                                  const JsonReader& camera_reading);

// `imageOrientation.rotation`, by how many degrees clockwise the picture as sent is to be turned to
// be upright, in [0, 360): a multiple of 90. Nothing if the reading does not say.
std::optional<int> ReadRotationDeg(const JsonReader& camera_reading);

// The turn about the optical axis that takes the frame of a picture as sent into that of the
// upright one.
Eigen::Quaterniond UprightFromSent(int rotation_deg);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_GEOPOSE_READINGS_H_
