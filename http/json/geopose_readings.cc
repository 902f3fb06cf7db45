#include "http/json/geopose_readings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/angles.h"
#include "core/geoid.h"
#include "core/wire/json_members.h"
#include "http/json/request_photos.h"

namespace cairn {
namespace {

constexpr double kMaxDeviceHeightM = 10'000.0;
// Assumed maximum speed of the camera since a prior pose.
constexpr double kMaxSpeedMPerS = 3.0;
constexpr double kStandardGravity = 9.80665;
constexpr double kGravityTolerance = 0.03;
constexpr double kMaxGravityAgeMs = 500.0;

// Milliseconds between two times; 0 if either is unknown.
double AgeMs(std::optional<double> a, std::optional<double> b) {
  return a && b ? std::abs(*a - *b) : 0.0;
}

// Sets the height, and its standard deviation if the reading states it.
void ReadAltitude(const JsonReader& reading, PositionPrior* prior) {
  const auto altitude = reading.Find("altitude");
  const auto accuracy = reading.Find("altitudeAccuracy");
  if (!altitude) {
    return;
  }
  const double height_m = altitude->Number();
  const double sigma_m = accuracy ? accuracy->Number() : 0.0;
  if (!(std::abs(height_m) <= kMaxDeviceHeightM)) {
    return;
  }
  prior->position.h_m = height_m;
  const auto reference = reading.Find("altitudeReference");
  if (reference) {
    prior->position = WithEllipsoidalHeight(prior->position, ReadHeightReference(*reference));
  }
  if (!(sigma_m > 0.0 && sigma_m <= PositionPrior::kMaxAccuracyM)) {
    return;
  }
  const Geodetic& place = prior->position;
  prior->height_sigma_m =
      reference ? sigma_m
                : std::hypot(sigma_m, Geoid::Egm96().HeightM(place.lat_rad, place.lon_rad));
}

// Returns nothing if the reading is marked invalid.
std::optional<PositionPrior> ReadGeolocation(const JsonReader& reading) {
  const double lat_deg = reading.At("latitude").Number(-90.0, 90.0);
  const double lon_deg = reading.At("longitude").Number(-180.0, 180.0);
  const auto accuracy = reading.Find("accuracy");
  const double accuracy_m = accuracy ? accuracy->Number() : 0.0;
  const bool is_unset = lat_deg == 0.0 && lon_deg == 0.0;
  if (is_unset || accuracy_m < 0.0 || accuracy_m > PositionPrior::kMaxAccuracyM) {
    return std::nullopt;
  }
  PositionPrior prior;
  prior.position = Geodetic::FromDegrees(lat_deg, lon_deg, 0.0);
  prior.accuracy_m = accuracy_m > 0.0 ? accuracy_m : kUnknownAccuracyM;
  ReadAltitude(reading, &prior);
  return prior;
}

// A pose from an earlier response, as an OGC GeoPose with or without accuracy.
std::optional<PositionPrior> ReadPriorPose(const JsonReader& pose, std::optional<double> time_ms) {
  const JsonReader geopose = pose.Has("geopose") ? pose.At("geopose") : pose;
  const JsonReader position = geopose.At("position");
  const auto accuracy = pose.Find("accuracy");
  const auto position_accuracy = accuracy ? accuracy->Find("position") : std::nullopt;
  const double accuracy_m = position_accuracy ? position_accuracy->Number() : 0.0;
  if (accuracy_m < 0.0 || accuracy_m > PositionPrior::kMaxAccuracyM) {
    return std::nullopt;
  }
  const double moved_m = kMaxSpeedMPerS * 1e-3 * AgeMs(time_ms, TimeOf(pose));
  const double radius_m = moved_m + (accuracy_m > 0.0 ? accuracy_m : kUnknownAccuracyM);
  if (radius_m > PositionPrior::kMaxAccuracyM) {
    return std::nullopt;
  }
  PositionPrior prior;
  prior.position = ReadGeodetic(position.At("lat"), position.At("lon"), position.Find("h"));
  prior.accuracy_m = radius_m;
  if (position.Has("h")) {
    prior.height_sigma_m = radius_m;
  }
  return prior;
}

// The elements of a member; empty if the member is absent.
std::vector<JsonReader> ElementsOf(const JsonReader& json, const char* member) {
  const auto array = json.Find(member);
  return array ? array->Elements(0, kMaxReadings) : std::vector<JsonReader>();
}

// The direction of the acceleration of a device at rest: up, in the accelerometer's axes.
std::optional<Eigen::Vector3d> ReadAtRest(const JsonReader& reading) {
  const Eigen::Vector3d acceleration(reading.At("x").Number(), reading.At("y").Number(),
                                     reading.At("z").Number());
  const double ratio = acceleration.norm() / kStandardGravity;
  if (!(std::abs(ratio - 1.0) <= kGravityTolerance)) {
    return std::nullopt;
  }
  return acceleration.normalized();
}

}  // namespace

std::vector<JsonReader> ReadingsOf(const JsonReader& readings, const char* member,
                                   const char* other_spelling) {
  std::vector<JsonReader> elements = ElementsOf(readings, member);
  for (const JsonReader& element : ElementsOf(readings, other_spelling)) {
    elements.push_back(element);
  }
  return elements;
}

std::optional<double> TimeOf(const JsonReader& reading) {
  const auto time = reading.Find("timestamp");
  return time ? std::optional(time->Number(-kMaxExactInteger, kMaxExactInteger)) : std::nullopt;
}

std::optional<RigPlace> RigPlaceOf(const JsonReader& request, const JsonReader& reading) {
  const auto id = reading.Find("sensorId");
  if (!id) {
    return std::nullopt;
  }
  for (const JsonReader& sensor : ElementsOf(request, "sensors")) {
    const auto sensor_id = sensor.Find("id");
    if (!sensor_id || sensor_id->String() != id->String()) {
      continue;
    }
    const auto rig = sensor.Find("rigIdentifier");
    const auto rotation = sensor.Find("rigRotation");
    if (!rig || rig->String().empty() || !rotation) {
      return std::nullopt;
    }
    RigPlace place{rig->String(), {ReadQuaternion(*rotation), Eigen::Vector3d::Zero()}};
    if (const auto translation = sensor.Find("rigTranslation")) {
      const auto component = [&](const char* name) {
        return translation->At(name).Number(-RigCamera::kMaxOffsetM, RigCamera::kMaxOffsetM);
      };
      place.sensor_from_rig.translation = {component("x"), component("y"), component("z")};
    }
    return place;
  }
  return std::nullopt;
}

std::optional<PositionPrior> ReadGeoPosePrior(const JsonReader& request,
                                              std::optional<double> time_ms) {
  std::optional<PositionPrior> best;
  double best_age_ms = 0.0;
  for (const JsonReader& reading :
       ReadingsOf(request.At("sensorReadings"), "geolocationReadings", "geoLocationReadings")) {
    const std::optional<PositionPrior> prior = ReadGeolocation(reading);
    const double age_ms = AgeMs(time_ms, TimeOf(reading));
    const auto is_better = [&] {
      return !best || age_ms < best_age_ms ||
             (age_ms == best_age_ms && prior->accuracy_m < best->accuracy_m);
    };
    if (prior && is_better()) {
      best = prior;
      best_age_ms = age_ms;
    }
  }
  for (const JsonReader& pose : ElementsOf(request, "priorPoses")) {
    const std::optional<PositionPrior> prior = ReadPriorPose(pose, time_ms);
    if (prior && (!best || prior->accuracy_m < best->accuracy_m)) {
      best = prior;
    }
  }
  return best;
}

std::optional<int> ReadRotationDeg(const JsonReader& camera_reading) {
  const auto orientation = camera_reading.Find("imageOrientation");
  if (!orientation) {
    return std::nullopt;
  }
  if (const auto mirrored = orientation->Find("mirrored"); mirrored && mirrored->Bool()) {
    mirrored->Fail("is true: a mirrored image cannot be localized; send the camera's own pixels");
  }
  const auto rotation = orientation->Find("rotation");
  if (!rotation) {
    return std::nullopt;
  }
  const double turns = rotation->Number(-3600.0, 3600.0) / 90.0;
  if (turns != std::round(turns)) {
    rotation->Fail("is no multiple of 90 degrees",
                   "send the clockwise turn that makes the picture upright");
  }
  return (static_cast<int>(turns) % 4 + 4) % 4 * 90;
}

Eigen::Quaterniond UprightFromSent(int rotation_deg) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(rotation_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()));
}

std::optional<Eigen::Vector3d> ReadGeoPoseGravity(const JsonReader& request,
                                                  const JsonReader& camera_reading) {
  const auto time_ms = TimeOf(camera_reading);
  std::optional<JsonReader> nearest;
  for (const JsonReader& reading :
       ElementsOf(request.At("sensorReadings"), "accelerometerReadings")) {
    const double age_ms = AgeMs(time_ms, TimeOf(reading));
    if (age_ms <= kMaxGravityAgeMs && (!nearest || age_ms < AgeMs(time_ms, TimeOf(*nearest)))) {
      nearest = reading;
    }
  }
  const auto up = nearest ? ReadAtRest(*nearest) : std::nullopt;
  if (!up) {
    return std::nullopt;
  }
  const auto camera_place = RigPlaceOf(request, camera_reading);
  const auto place = RigPlaceOf(request, *nearest);
  if (camera_place && place && camera_place->rig == place->rig) {
    return -(camera_place->sensor_from_rig.rotation * place->sensor_from_rig.rotation.conjugate() *
             *up);
  }
  const std::optional<int> rotation_deg = ReadRotationDeg(camera_reading);
  if (!rotation_deg) {
    return std::nullopt;
  }
  const Eigen::Vector3d down_in_upright(-up->x(), up->y(), up->z());
  return UprightFromSent(*rotation_deg).conjugate() * down_in_upright;
}

}  // namespace cairn
