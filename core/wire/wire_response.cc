#include "core/wire/wire_response.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/angles.h"
#include "core/wire/json_members.h"
#include "core/wire/stated_camera.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr char kLocalized[] = "LOCALIZED";
constexpr double kMaxNumber = std::numeric_limits<double>::max();

// A number of a pose or of a match and its name. Each table serves both directions.
template <typename Struct>
struct NumberField {
  const char* name;
  double Struct::*value;
};
constexpr NumberField<WirePose> kPoseNumbers[] = {
    {"confidence", &WirePose::confidence},
    {"score", &WirePose::score},
    {"falseAlarmRate", &WirePose::false_alarm_rate},
};
constexpr NumberField<WireMatch> kMatchNumbers[] = {
    {"error", &WireMatch::error_px},
    {"probability", &WireMatch::right_probability},
};
constexpr NumberField<CameraEstimate> kCameraNumbers[] = {
    {"focalLengthAccuracy", &CameraEstimate::focal_sigma_px},
    {"assumedFocalLength", &CameraEstimate::assumed_focal_px},
    {"assumedFocalLengthAccuracy", &CameraEstimate::assumed_focal_sigma_px},
};

template <typename Struct, size_t kSize>
void AddNumbers(const NumberField<Struct> (&fields)[kSize], const Struct& from, Json* json) {
  for (const NumberField<Struct>& field : fields) {
    (*json)[field.name] = from.*field.value;
  }
}

// Numbers that describe, and without which a device can use the answer, may be missing.
template <typename Struct, size_t kSize>
void ReadNumbers(const NumberField<Struct> (&fields)[kSize], const JsonReader& json, Struct* to) {
  for (const NumberField<Struct>& field : fields) {
    if (const auto number = json.Find(field.name)) {
      to->*field.value = number->Number();
    }
  }
}

Json GeoPoseJson(const GeoPose& geopose) {
  return {{"position", GeodeticJson(geopose.position)},
          {"quaternion", QuaternionJson(geopose.enu_from_inner)}};
}

GeoPose ReadGeoPose(const JsonReader& json) {
  constexpr double kTolerance = 1e-3;
  return {.position = ReadGeodetic(json.At("position")),
          .enu_from_inner = ReadQuaternion(json.At("quaternion"), kTolerance).normalized()};
}

Json AccuracyJson(const WireAccuracy& accuracy) {
  return {{"position", accuracy.position_m}, {"orientation", accuracy.rotation_rad * kDegPerRad}};
}

WireAccuracy ReadAccuracy(const JsonReader& json) {
  return {.position_m = json.At("position").Number(),
          .rotation_rad = json.At("orientation").Number() / kDegPerRad};
}

Json CameraEstimateJson(const CameraEstimate& estimate) {
  Json json = CameraJson(estimate.camera);
  json["estimated"] = true;
  json["focalLength"] = estimate.camera.focal_px();
  AddNumbers(kCameraNumbers, estimate, &json);
  json["focalLengthDisagrees"] = estimate.focal_disagrees;
  json["offCenter"] = estimate.is_off_center;
  return json;
}

CameraEstimate ReadCameraEstimate(const JsonReader& json) {
  CameraEstimate estimate;
  estimate.camera =
      ReadCameraParts(json.At("model"), ReadImageSize(json.At("size")), json.At("modelParams"))
          .camera;
  ReadNumbers(kCameraNumbers, json, &estimate);
  estimate.focal_disagrees = json.At("focalLengthDisagrees").Bool();
  if (const auto off_center = json.Find("offCenter")) {
    estimate.is_off_center = off_center->Bool();
  }
  return estimate;
}

void AddPose(const WirePose& pose, Json* json) {
  (*json)["geopose"] = GeoPoseJson(pose.geopose);
  (*json)["innerFrame"] = InnerFrameName(pose.inner_frame);
  (*json)["accuracy"] = AccuracyJson(pose.accuracy);
  if (pose.accuracy_on_earth) {
    (*json)["accuracyOnEarth"] = AccuracyJson(*pose.accuracy_on_earth);
  }
  if (pose.covariance) {
    // The matrix is symmetric, so the storage order does not matter.
    const double* numbers = pose.covariance->data();
    (*json)["covariance"] = std::vector<double>(numbers, numbers + pose.covariance->size());
  }
  if (pose.camera) {
    (*json)["camera"] = CameraEstimateJson(*pose.camera);
  }
  AddNumbers(kPoseNumbers, pose, json);
  (*json)["priorDisagrees"] = pose.prior_disagrees;
  (*json)["inlierCount"] = pose.num_inliers;
  (*json)["anchor"] = GeodeticJson(pose.anchor);
}

WirePose ReadPose(const JsonReader& json) {
  const JsonReader name = json.At("innerFrame");
  const auto frame = InnerFrameFromName(name.String());
  if (!frame) {
    name.Fail("is unknown");
  }
  WirePose pose{.geopose = ReadGeoPose(json.At("geopose")),
                .inner_frame = *frame,
                .anchor = ReadGeodetic(json.At("anchor")),
                .accuracy = ReadAccuracy(json.At("accuracy"))};
  if (const auto on_earth = json.Find("accuracyOnEarth")) {
    pose.accuracy_on_earth = ReadAccuracy(*on_earth);
  }
  if (const auto covariance = json.Find("covariance")) {
    const std::vector<double> numbers = covariance->Numbers(36, 36);
    pose.covariance = Eigen::Map<const Matrix6d>(numbers.data());
  }
  if (const auto camera = json.Find("camera")) {
    pose.camera = ReadCameraEstimate(*camera);
  }
  ReadNumbers(kPoseNumbers, json, &pose);
  if (const auto disagrees = json.Find("priorDisagrees")) {
    pose.prior_disagrees = disagrees->Bool();
  }
  if (const auto count = json.Find("inlierCount")) {
    pose.num_inliers = count->Integer(0, kMaxExactInteger);
  }
  return pose;
}

Json UsedPriorJson(const std::optional<PositionPrior>& prior) {
  if (!prior) {
    return nullptr;
  }
  return {{"source", PriorSourceName(prior->source)},
          {"position", GeodeticJson(prior->position)},
          {"accuracy", prior->accuracy_m}};
}

// Nothing if the server knows a source that this program does not know.
std::optional<PositionPrior> ReadUsedPrior(const JsonReader& json) {
  const auto source = PriorSourceFromName(json.At("source").String());
  if (!source) {
    return std::nullopt;
  }
  return PositionPrior{.position = ReadGeodetic(json.At("position")),
                       .accuracy_m = json.At("accuracy").Number(),
                       .source = *source};
}

Json MatchJson(const WireMatch& match) {
  Json json = {{"u", match.pixel.x()},
               {"v", match.pixel.y()},
               {"landmarkId", match.landmark_id},
               {"enu", VectorJson(match.x_in_anchor)},
               {"sigma", match.sigma_m}};
  AddNumbers(kMatchNumbers, match, &json);
  json["keypoint"] = match.keypoint_idx;
  json["tile"] = match.tile_idx;
  if (match.camera_idx > 0) {
    json["camera"] = match.camera_idx;
  }
  return json;
}

WireMatch ReadMatch(const JsonReader& json, size_t num_tiles) {
  WireMatch match;
  match.pixel = {json.At("u").Number(), json.At("v").Number()};
  match.landmark_id = json.At("landmarkId").Integer(0, kMaxExactInteger);
  match.x_in_anchor = ReadVector(json.At("enu"));
  match.sigma_m = json.At("sigma").Number(0.0, kMaxNumber);
  ReadNumbers(kMatchNumbers, json, &match);
  match.keypoint_idx = static_cast<int>(json.At("keypoint").Integer(0, 1 << 30));
  match.tile_idx =
      static_cast<int>(json.At("tile").Integer(0, static_cast<int64_t>(num_tiles) - 1));
  if (const auto camera = json.Find("camera")) {
    match.camera_idx = static_cast<int>(camera->Integer(0, RigCamera::kMaxOthers));
  }
  return match;
}

Json MapJson(const WireResponse& response) {
  Json tiles = Json::array();
  for (const TileId& tile : response.tiles) {
    tiles.push_back(tile.ToString());
  }
  Json json = {{"version", response.map_version}, {"tiles", std::move(tiles)}};
  if (response.map_is_stale) {
    json["stale"] = true;
  }
  return json;
}

void ReadMap(const JsonReader& json, WireResponse* response) {
  if (const auto version = json.Find("version")) {
    response->map_version = version->Integer(0, kMaxExactInteger);
  }
  if (const auto tiles = json.Find("tiles")) {
    for (const JsonReader& tile : tiles->Elements(0, kAnswerLimits.max_elements)) {
      response->tiles.push_back(TileId::Parse(tile.String()));
    }
  }
  if (const auto stale = json.Find("stale")) {
    response->map_is_stale = stale->Bool();
  }
}

}  // namespace

Json WireResponseJson(const WireResponse& response) {
  Json json = {{"id", response.id}};
  if (response.timestamp_ms) {
    json["timestamp"] = *response.timestamp_ms;
  }
  json["status"] = response.pose ? kLocalized : "NOT_LOCALIZED";
  json["reason"] = response.pose ? Json(nullptr) : Json(response.reason);
  if (!response.reason_text.empty()) {
    json["reasonText"] = response.reason_text;
  }
  json["prior"] = UsedPriorJson(response.prior);
  if (response.is_upright) {
    json["imageOrientation"] = ImageOrientationName(ImageOrientation::kUpright);
  }
  if (response.pose) {
    AddPose(*response.pose, &json);
  }
  if (response.matches) {
    Json& matches = json["matches"] = Json::array();
    for (const WireMatch& match : *response.matches) {
      matches.push_back(MatchJson(match));
    }
  }
  json["map"] = MapJson(response);
  return json;
}

WireResponse ReadWireResponse(const JsonReader& json) {
  WireResponse response;
  if (const auto id = json.Find("id")) {
    response.id = id->String();
  }
  if (const auto timestamp = json.Find("timestamp")) {
    response.timestamp_ms = timestamp->Integer(-kMaxExactInteger, kMaxExactInteger);
  }
  if (json.At("status").String() == kLocalized) {
    response.pose = ReadPose(json);
  } else if (const auto reason = json.Find("reason")) {
    response.reason = reason->String();
  }
  if (const auto text = json.Find("reasonText")) {
    response.reason_text = text->String();
  }
  if (const auto prior = json.Find("prior")) {
    response.prior = ReadUsedPrior(*prior);
  }
  if (const auto turned = json.Find("imageOrientation")) {
    response.is_upright = turned->String() == ImageOrientationName(ImageOrientation::kUpright);
  }
  if (const auto map = json.Find("map")) {
    ReadMap(*map, &response);
  }
  if (const auto matches = json.Find("matches")) {
    response.matches.emplace();
    for (const JsonReader& match : matches->Elements(0, kAnswerLimits.max_elements)) {
      response.matches->push_back(ReadMatch(match, response.tiles.size()));
    }
  }
  return response;
}

}  // namespace cairn
