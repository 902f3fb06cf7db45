#include "http/json/localize_response.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/printable.h"
#include "core/wire/json_reader.h"
#include "core/wire/wire_response.h"

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

WireMatch ToWire(const LocalizeMatch& match) {
  return {.pixel = match.pixel,
          .landmark_id = Value(match.landmark_id),
          .x_in_anchor = match.x_in_anchor,
          .sigma_m = match.sigma_m,
          .error_px = match.traits.error_px,
          .right_probability = match.right_probability,
          .keypoint_idx = match.keypoint_idx,
          .tile_idx = match.tile_idx,
          .camera_idx = match.camera_idx};
}

LocalizeMatch FromWire(const WireMatch& match) {
  return {.keypoint_idx = match.keypoint_idx,
          .camera_idx = match.camera_idx,
          .pixel = match.pixel,
          .landmark_id = LandmarkId(match.landmark_id),
          .tile_idx = match.tile_idx,
          .x_in_anchor = match.x_in_anchor,
          .sigma_m = match.sigma_m,
          .right_probability = match.right_probability,
          .traits = {.error_px = match.error_px}};
}

std::vector<WireMatch> ThinnedMatches(const LocalizeResult& result, int max_matches) {
  const size_t num_all = result.matches.size();
  const size_t num_sent = std::min<size_t>(num_all, max_matches);
  std::vector<WireMatch> matches;
  matches.reserve(num_sent);
  for (size_t i = 0; i < num_sent; ++i) {
    matches.push_back(ToWire(result.matches[i * num_all / num_sent]));
  }
  return matches;
}

WirePose PoseOf(const LocalizeResult& result, const ResponseOptions& options) {
  WirePose pose{
      .geopose = GeoPoseFromCamera(result.cam_from_ecef, options.inner_frame),
      .inner_frame = options.inner_frame,
      .anchor = result.anchor,
      .accuracy = {result.position_accuracy_m, result.rotation_accuracy_rad},
      .accuracy_on_earth = WireAccuracy{result.EarthAccuracyM(), result.EarthAccuracyRad()},
      .camera = result.camera,
      .confidence = result.confidence,
      .score = result.score,
      .false_alarm_rate = result.false_alarm_rate,
      .prior_disagrees = result.prior_disagrees,
      .num_inliers = std::ssize(result.matches)};
  if (options.with_covariance) {
    pose.covariance =
        WireCovariance(result.covariance, EnuFromAnchor(pose.geopose.position, result.anchor));
  }
  return pose;
}

// Returns what a radius holds beside a smaller one.
double Remainder(double radius, double part) {
  return std::sqrt(std::max(0.0, radius * radius - part * part));
}

void SetPose(const WirePose& pose, LocalizeResult* result) {
  result->localized = true;
  result->cam_from_ecef = CameraFromGeoPose(pose.geopose, pose.inner_frame);
  result->position = pose.geopose.position;
  result->anchor = pose.anchor;
  result->cam_from_anchor = result->cam_from_ecef * EcefFromEnu(result->anchor);
  result->position_accuracy_m = pose.accuracy.position_m;
  result->rotation_accuracy_rad = pose.accuracy.rotation_rad;
  if (pose.accuracy_on_earth) {
    result->map_accuracy_m =
        Remainder(pose.accuracy_on_earth->position_m, result->position_accuracy_m);
    result->map_accuracy_rad =
        Remainder(pose.accuracy_on_earth->rotation_rad, result->rotation_accuracy_rad);
  }
  result->confidence = pose.confidence;
  result->score = pose.score;
  result->false_alarm_rate = pose.false_alarm_rate;
  result->prior_disagrees = pose.prior_disagrees;
  result->camera = pose.camera;
  if (pose.covariance) {
    result->covariance =
        ResultCovariance(*pose.covariance, EnuFromAnchor(result->position, result->anchor));
  }
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

NotLocalizedReason ReasonFromName(const std::string& name) {
  for (const NotLocalizedReason reason : kReasons) {
    if (NotLocalizedReasonName(reason) == name) {
      return reason;
    }
  }
  throw Error(ErrorCode::kBadInput, fmt::format("/reason: '{}' is unknown", Excerpt(name)));
}

WireResponse ToWire(const LocalizeResult& result, const LocalizeRequest& request) {
  WireResponse wire{.id = request.query.id, .timestamp_ms = request.timestamp_ms};
  if (result.localized) {
    wire.pose = PoseOf(result, request.answer);
    if (request.answer.with_matches) {
      wire.matches = ThinnedMatches(result, request.answer.max_matches);
    }
  } else {
    wire.reason = NotLocalizedReasonName(result.reason);
    wire.reason_text = result.reason_text;
  }
  wire.prior = request.query.prior;
  wire.is_upright = request.has_images() && request.images.front().orientation != 1;
  wire.map_version = Value(result.map_version);
  wire.map_is_stale = result.map_is_stale;
  wire.tiles = result.tiles;
  return wire;
}

LocalizeResult FromWire(WireResponse wire) {
  LocalizeResult result;
  if (wire.pose) {
    SetPose(*wire.pose, &result);
  } else {
    result.reason = ReasonFromName(wire.reason);
    result.reason_text = std::move(wire.reason_text);
  }
  if (wire.matches) {
    result.matches.reserve(wire.matches->size());
    for (const WireMatch& match : *wire.matches) {
      result.matches.push_back(FromWire(match));
    }
  }
  result.map_version = MapVersion(wire.map_version);
  result.map_is_stale = wire.map_is_stale;
  result.tiles = std::move(wire.tiles);
  return result;
}

}  // namespace

std::string LocalizeResponseJson(const LocalizeResult& result, const LocalizeRequest& request,
                                 const ServerTimes& times) {
  Json json = WireResponseJson(ToWire(result, request));
  json["stages"] = StagesJson(result, times, request.has_images(), request.answer.with_timings);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

LocalizeResult ParseLocalizeResponse(std::string_view text) {
  try {
    const JsonDocument document = ParseJson(text, kAnswerLimits);
    const JsonReader json(document);
    LocalizeResult result = FromWire(ReadWireResponse(json));
    ReadStages(json.At("stages"), &result);
    return result;
  } catch (const Error& e) {
    throw Error(ErrorCode::kBadInput,
                std::string("this client cannot read the server's response: ") + e.what());
  }
}

}  // namespace cairn
