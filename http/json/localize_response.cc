#include "http/json/localize_response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/angles.h"
#include "core/error.h"
#include "core/wire/json_reader.h"
#include "http/json/request_members.h"
#include "http/json/stated_camera.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr std::array kReasons = {
    NotLocalizedReason::kNone,           NotLocalizedReason::kNoCoverage,
    NotLocalizedReason::kTooFewFeatures, NotLocalizedReason::kTooFewMatches,
    NotLocalizedReason::kTooFewInliers,  NotLocalizedReason::kAmbiguous,
    NotLocalizedReason::kPriorMismatch,  NotLocalizedReason::kTimeout,
};

// A counter and its place on the wire. One table serves both directions.
struct CounterField {
  Stage stage;
  const char* name;
  int64_t StageCounters::*value;
};
constexpr std::array kCounters = {
    CounterField{Stage::kTiles, "places", &StageCounters::num_places_searched},
    CounterField{Stage::kTiles, "found", &StageCounters::num_tiles_found},
    CounterField{Stage::kTiles, "searched", &StageCounters::num_tiles_searched},
    CounterField{Stage::kTiles, "loaded", &StageCounters::num_tiles_loaded},
    CounterField{Stage::kTiles, "descriptors", &StageCounters::num_descriptors},
    CounterField{Stage::kMatching, "keypoints", &StageCounters::num_keypoints},
    CounterField{Stage::kMatching, "distances", &StageCounters::num_distances},
    CounterField{Stage::kMatching, "matches", &StageCounters::num_matches},
    CounterField{Stage::kMatching, "matchedKeypoints", &StageCounters::num_matched_keypoints},
    CounterField{Stage::kVoting, "votes", &StageCounters::num_votes},
    CounterField{Stage::kVoting, "candidates", &StageCounters::num_candidates},
    CounterField{Stage::kPose, "iterations", &StageCounters::num_ransac_iterations},
    CounterField{Stage::kRefinement, "keyframes", &StageCounters::num_refined_keyframes},
    CounterField{Stage::kRefinement, "rematches", &StageCounters::num_rematches},
};

struct FlagField {
  Stage stage;
  const char* name;
  bool StageCounters::*value;
};
constexpr std::array kFlags = {
    FlagField{Stage::kPrior, "usedPosition", &StageCounters::used_prior},
    FlagField{Stage::kPrior, "usedGravity", &StageCounters::used_gravity},
    FlagField{Stage::kTiles, "limitHit", &StageCounters::tile_limit_hit},
    FlagField{Stage::kTiles, "cutShort", &StageCounters::tiles_cut_short},
    FlagField{Stage::kMatching, "cutShort", &StageCounters::matching_cut_short},
    FlagField{Stage::kPose, "cutShort", &StageCounters::pose_cut_short},
    FlagField{Stage::kRefinement, "cutShort", &StageCounters::refinement_cut_short},
};

Json GeodeticJson(const Geodetic& position) {
  return {{"lat", position.lat_deg()}, {"lon", position.lon_deg()}, {"h", position.h_m}};
}

// Converts a covariance of (rotation, translation) in the anchor frame to one of (translation,
// rotation) in enu at the camera: J C J' with J = [[0, R], [R, 0]], R = enu_from_anchor.
Matrix6d WireCovariance(const Matrix6d& covariance, const Eigen::Matrix3d& enu_from_anchor) {
  Matrix6d jacobian = Matrix6d::Zero();
  jacobian.topRightCorner<3, 3>() = enu_from_anchor;
  jacobian.bottomLeftCorner<3, 3>() = enu_from_anchor;
  return jacobian * covariance * jacobian.transpose();
}

Matrix6d ResultCovariance(const Matrix6d& wire, const Eigen::Matrix3d& enu_from_anchor) {
  return WireCovariance(wire, enu_from_anchor.transpose());
}

Eigen::Matrix3d EnuFromAnchor(const Geodetic& position, const Geodetic& anchor) {
  return (EcefFromEnu(position).rotation.conjugate() * EcefFromEnu(anchor).rotation)
      .toRotationMatrix();
}

Json MatchesJson(const LocalizeResult& result, int max_matches) {
  const size_t num_all = result.matches.size();
  const size_t num_sent = std::min<size_t>(num_all, max_matches);
  Json matches = Json::array();
  for (size_t i = 0; i < num_sent; ++i) {
    const LocalizeMatch& match = result.matches[i * num_all / num_sent];
    Json& json = matches.emplace_back(
        Json{{"u", match.pixel.x()},
             {"v", match.pixel.y()},
             {"landmarkId", Value(match.landmark_id)},
             {"enu", {match.x_in_anchor.x(), match.x_in_anchor.y(), match.x_in_anchor.z()}},
             {"sigma", match.sigma_m},
             {"error", match.traits.error_px},
             {"probability", match.right_probability},
             {"keypoint", match.keypoint_idx},
             {"tile", match.tile_idx}});
    if (match.camera_idx > 0) {
      json["camera"] = match.camera_idx;
    }
  }
  return matches;
}

Json StagesJson(const LocalizeResult& result, const ServerTimes& times, bool has_image,
                bool with_timings) {
  Json stages = Json::object();
  if (has_image && with_timings) {
    stages["extraction"] = {{"decodeMs", 1e3 * times.decode_seconds},
                            {"ms", 1e3 * times.extract_seconds}};
  }
  for (int i = 0; i < kNumStages; ++i) {
    const auto stage = static_cast<Stage>(i);
    Json fields = Json::object();
    if (with_timings) {
      fields["ms"] = 1e3 * result.times.seconds[i];
    }
    for (const FlagField& flag : kFlags) {
      if (flag.stage == stage) {
        fields[flag.name] = result.counters.*flag.value;
      }
    }
    for (const CounterField& counter : kCounters) {
      if (counter.stage == stage) {
        fields[counter.name] = result.counters.*counter.value;
      }
    }
    stages[StageName(stage)] = std::move(fields);
  }
  if (with_timings) {
    stages["totalMs"] = 1e3 * result.times.total_seconds;
  }
  return stages;
}

// The prior that the answer is based on.
Json PriorJson(const std::optional<PositionPrior>& prior) {
  if (!prior) {
    return nullptr;
  }
  return {{"source", PriorSourceName(prior->source)},
          {"position", GeodeticJson(prior->position)},
          {"accuracy", prior->accuracy_m}};
}

Json CameraJson(const CameraEstimate& estimate) {
  const Camera& camera = estimate.camera;
  return {{"model", CameraModelName(camera.model())},
          {"size", {camera.width_px(), camera.height_px()}},
          {"modelParams", camera.params()},
          {"estimated", true},
          {"focalLength", camera.focal_px()},
          {"focalLengthAccuracy", estimate.focal_sigma_px},
          {"assumedFocalLength", estimate.assumed_focal_px},
          {"assumedFocalLengthAccuracy", estimate.assumed_focal_sigma_px},
          {"focalLengthDisagrees", estimate.focal_disagrees}};
}

void AddPose(const LocalizeResult& result, const ResponseOptions& options, Json* json) {
  const GeoPose geopose = GeoPoseFromCamera(result.cam_from_ecef, options.inner_frame);
  const Eigen::Quaterniond& q = geopose.enu_from_inner;
  (*json)["geopose"] = {{"position", GeodeticJson(geopose.position)},
                        {"quaternion", {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}}};
  (*json)["innerFrame"] = InnerFrameName(options.inner_frame);
  (*json)["accuracy"] = {{"position", result.position_accuracy_m},
                         {"orientation", result.rotation_accuracy_rad * kDegPerRad}};
  (*json)["accuracyOnEarth"] = {{"position", result.EarthAccuracyM()},
                                {"orientation", result.EarthAccuracyRad() * kDegPerRad}};
  if (options.with_covariance) {
    const Matrix6d wire =
        WireCovariance(result.covariance, EnuFromAnchor(geopose.position, result.anchor));
    // The matrix is symmetric, so the storage order does not matter.
    (*json)["covariance"] = std::vector<double>(wire.data(), wire.data() + wire.size());
  }
  if (result.camera) {
    (*json)["camera"] = CameraJson(*result.camera);
  }
  (*json)["confidence"] = result.confidence;
  (*json)["score"] = result.score;
  (*json)["falseAlarmRate"] = result.false_alarm_rate;
  (*json)["priorDisagrees"] = result.prior_disagrees;
  (*json)["inlierCount"] = result.matches.size();
}

GeoPose ReadGeoPose(const JsonReader& json) {
  const JsonReader position = json.At("position");
  const JsonReader quaternion = json.At("quaternion");
  const auto component = [&](const char* name) { return quaternion.At(name).Number(-1.0, 1.0); };
  return {.position = ReadGeodetic(position.At("lat"), position.At("lon"), position.At("h")),
          .enu_from_inner =
              Eigen::Quaterniond(component("w"), component("x"), component("y"), component("z"))
                  .normalized()};
}

CameraEstimate ReadCameraEstimate(const JsonReader& json) {
  CameraEstimate estimate;
  estimate.camera =
      ReadCameraParts(json.At("model"), ReadImageSize(json.At("size")), json.At("modelParams"))
          .camera;
  estimate.focal_sigma_px = json.At("focalLengthAccuracy").Number();
  estimate.assumed_focal_px = json.At("assumedFocalLength").Number();
  estimate.assumed_focal_sigma_px = json.At("assumedFocalLengthAccuracy").Number();
  estimate.focal_disagrees = json.At("focalLengthDisagrees").Bool();
  return estimate;
}

// Returns what a radius holds beside a smaller one.
double Remainder(double radius, double part) {
  return std::sqrt(std::max(0.0, radius * radius - part * part));
}

void ReadPose(const JsonReader& json, LocalizeResult* result) {
  const GeoPose geopose = ReadGeoPose(json.At("geopose"));
  const auto frame = InnerFrameFromName(json.At("innerFrame").String());
  if (!frame) {
    json.At("innerFrame").Fail("is unknown");
  }
  result->cam_from_ecef = CameraFromGeoPose(geopose, *frame);
  result->position = geopose.position;
  const JsonReader anchor = json.At("anchor");
  result->anchor = ReadGeodetic(anchor.At("lat"), anchor.At("lon"), anchor.At("h"));
  result->cam_from_anchor = result->cam_from_ecef * EcefFromEnu(result->anchor);
  const JsonReader accuracy = json.At("accuracy");
  result->position_accuracy_m = accuracy.At("position").Number();
  result->rotation_accuracy_rad = accuracy.At("orientation").Number() / kDegPerRad;
  if (const auto on_earth = json.Find("accuracyOnEarth")) {  // Older servers do not send it.
    result->map_accuracy_m =
        Remainder(on_earth->At("position").Number(), result->position_accuracy_m);
    result->map_accuracy_rad =
        Remainder(on_earth->At("orientation").Number() / kDegPerRad, result->rotation_accuracy_rad);
  }
  result->confidence = json.At("confidence").Number();
  result->score = json.At("score").Number();
  result->false_alarm_rate = json.At("falseAlarmRate").Number();
  result->prior_disagrees = json.At("priorDisagrees").Bool();
  if (const auto camera = json.Find("camera")) {
    result->camera = ReadCameraEstimate(*camera);
  }
  if (const auto covariance = json.Find("covariance")) {
    const std::vector<double> numbers = covariance->Numbers(36, 36);
    result->covariance = ResultCovariance(Eigen::Map<const Matrix6d>(numbers.data()),
                                          EnuFromAnchor(result->position, result->anchor));
  }
}

LocalizeMatch ReadMatch(const JsonReader& json) {
  const std::vector<double> enu = json.At("enu").Numbers(3, 3);
  LocalizeMatch match;
  match.keypoint_idx = static_cast<int>(json.At("keypoint").Integer(0, 1 << 30));
  match.pixel = {json.At("u").Number(), json.At("v").Number()};
  match.landmark_id = LandmarkId(json.At("landmarkId").Integer(0, kMaxExactInteger));
  match.tile_idx = static_cast<int>(json.At("tile").Integer(0, 1 << 30));
  if (const auto camera = json.Find("camera")) {
    match.camera_idx = static_cast<int>(camera->Integer(0, LocalizeQuery::kMaxOtherCameras));
  }
  match.x_in_anchor = {enu[0], enu[1], enu[2]};
  match.sigma_m = json.At("sigma").Number();
  match.traits.error_px = json.At("error").Number();
  match.right_probability = json.At("probability").Number();
  return match;
}

void ReadStages(const JsonReader& json, LocalizeResult* result) {
  for (const CounterField& counter : kCounters) {
    result->counters.*counter.value =
        json.At(StageName(counter.stage)).At(counter.name).Integer(0, kMaxExactInteger);
  }
  for (const FlagField& flag : kFlags) {
    // Older servers send fewer flags.
    if (const auto value = json.At(StageName(flag.stage)).Find(flag.name)) {
      result->counters.*flag.value = value->Bool();
    }
  }
  for (int i = 0; i < kNumStages; ++i) {
    if (const auto ms = json.At(StageName(static_cast<Stage>(i))).Find("ms")) {
      result->times.seconds[i] = 1e-3 * ms->Number();
    }
  }
  if (const auto total = json.Find("totalMs")) {
    result->times.total_seconds = 1e-3 * total->Number();
  }
}

NotLocalizedReason ReadReason(const JsonReader& json) {
  for (const NotLocalizedReason reason : kReasons) {
    if (NotLocalizedReasonName(reason) == json.String()) {
      return reason;
    }
  }
  json.Fail("is unknown");
}

LocalizeResult ReadResult(const JsonReader& json) {
  LocalizeResult result;
  result.localized = json.At("status").String() == "LOCALIZED";
  if (result.localized) {
    ReadPose(json, &result);
  } else {
    result.reason = ReadReason(json.At("reason"));
    if (const auto text = json.Find("reasonText")) {
      result.reason_text = text->String();
    }
  }
  if (const auto matches = json.Find("matches")) {
    for (const JsonReader& match : matches->Elements(0, kAnswerLimits.max_elements)) {
      result.matches.push_back(ReadMatch(match));
    }
  }
  ReadStages(json.At("stages"), &result);
  const JsonReader map = json.At("map");
  result.map_version = MapVersion(map.At("version").Integer(0, kMaxExactInteger));
  if (const auto stale = map.Find("stale")) {
    result.map_is_stale = stale->Bool();
  }
  for (const JsonReader& tile : map.At("tiles").Elements(0, kAnswerLimits.max_elements)) {
    result.tiles.push_back(TileId::Parse(tile.String()));
  }
  return result;
}

}  // namespace

std::string LocalizeResponseJson(const LocalizeResult& result, const LocalizeRequest& request,
                                 const ServerTimes& times) {
  const ResponseOptions& options = request.answer;
  Json json = {{"id", request.query.id}};
  if (request.timestamp_ms) {
    json["timestamp"] = *request.timestamp_ms;
  }
  json["status"] = result.localized ? "LOCALIZED" : "NOT_LOCALIZED";
  json["reason"] = result.localized ? Json(nullptr) : Json(NotLocalizedReasonName(result.reason));
  if (!result.localized && !result.reason_text.empty()) {
    json["reasonText"] = result.reason_text;
  }
  json["prior"] = PriorJson(request.query.prior);
  if (request.has_images() && request.images.front().orientation != 1) {
    json["imageOrientation"] = ImageOrientationName(ImageOrientation::kUpright);
  }
  if (result.localized) {
    AddPose(result, options, &json);
  }
  json["stages"] = StagesJson(result, times, request.has_images(), options.with_timings);
  if (result.localized && options.with_matches) {
    json["matches"] = MatchesJson(result, options.max_matches);
  }
  if (result.localized) {
    json["anchor"] = GeodeticJson(result.anchor);
  }
  Json tiles = Json::array();
  for (const TileId& tile : result.tiles) {
    tiles.push_back(tile.ToString());
  }
  json["map"] = {{"version", Value(result.map_version)}, {"tiles", std::move(tiles)}};
  if (result.map_is_stale) {
    json["map"]["stale"] = true;
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

LocalizeResult ParseLocalizeResponse(std::string_view text) {
  try {
    const JsonDocument document = ParseJson(text, kAnswerLimits);
    return ReadResult(JsonReader(document));
  } catch (const Error& e) {
    throw Error(ErrorCode::kBadInput,
                std::string("this client cannot read the server's response: ") + e.what());
  }
}

}  // namespace cairn
