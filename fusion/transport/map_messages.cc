#include "fusion/transport/map_messages.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/cell_name.h"
#include "core/radius68.h"
#include "core/tile_id.h"
#include "core/wire/feature_codec.h"
#include "core/wire/json_reader.h"
#include "core/wire/multipart.h"

namespace cairn::fusion {
namespace {

using Json = nlohmann::json;

// The filter's accuracy may be finer than the server's search grid, so it is limited to this value.
constexpr double kMinAccuracyM = 1.0;

Json PriorJson(const Geodetic& position, double accuracy_m) {
  return {
      {"position", {{"lat", position.lat_deg()}, {"lon", position.lon_deg()}, {"h", position.h_m}}},
      {"accuracy", accuracy_m}};
}

// The position of the prior: the filter's, or else the receiver's.
std::optional<Geodetic> PriorPosition(const MapQuery& query, const Geodetic& global_origin) {
  if (const auto& prior = query.request.prior) {
    return GeodeticFromEcef(EcefFromEnu(global_origin) * prior->global_from_cam.translation);
  }
  return query.rough_position ? std::optional(query.rough_position->position) : std::nullopt;
}

// The prior of the camera's position at `position`, which PriorPosition returned.
Json PriorOf(const MapQuery& query, const Geodetic& position) {
  if (const auto& prior = query.request.prior) {
    const Eigen::Matrix3d covariance = prior->covariance.bottomRightCorner<3, 3>();
    const double horizontal = std::max(covariance(0, 0), covariance(1, 1));
    Json json =
        PriorJson(position, std::max(kMinAccuracyM, kRadius68PerSigma2d * std::sqrt(horizontal)));
    json["altitudeAccuracy"] = std::max(kMinAccuracyM, std::sqrt(covariance(2, 2)));
    return json;
  }
  return PriorJson(position, query.rough_position->accuracy_m);
}

std::string RequestJson(const MapQuery& query, const std::optional<Geodetic>& prior_position,
                        int timeout_ms, int max_matches) {
  const Eigen::Vector3d& down = query.request.down_in_cam;
  Json json = {{"id", std::to_string(query.request.query_id)},
               {"camera",
                {{"model", CameraModelName(query.camera.model())},
                 {"size", {query.camera.width_px(), query.camera.height_px()}},
                 {"modelParams", query.camera.params()}}},
               {"gravity", {down.x(), down.y(), down.z()}},
               {"options",
                {{"innerFrame", "RDF"},
                 {"timeoutMs", timeout_ms},
                 {"maxMatches", max_matches},
                 {"include", {"matches"}}}}};
  if (prior_position) {
    json["prior"] = PriorOf(query, *prior_position);
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Geodetic ReadGeodetic(const JsonReader& json) {
  const Geodetic position = Geodetic::FromDegrees(json.At("lat").Number(), json.At("lon").Number(),
                                                  json.At("h").Number());
  ValidateGeodetic(position, "position");
  return position;
}

Rigid3d ReadPose(const JsonReader& json, const Rigid3d& global_from_ecef) {
  if (json.At("innerFrame").String() != "RDF") {
    json.At("innerFrame").Fail("is another inner frame than asked for");
  }
  const JsonReader q = json.At("geopose").At("quaternion");
  const Eigen::Quaterniond enu_from_cam(q.At("w").Number(), q.At("x").Number(), q.At("y").Number(),
                                        q.At("z").Number());
  if (std::abs(enu_from_cam.norm() - 1.0) > 1e-3) {
    q.Fail("is not of unit length");
  }
  const Rigid3d ecef_from_enu = EcefFromEnu(ReadGeodetic(json.At("geopose").At("position")));
  return global_from_ecef * ecef_from_enu * Rigid3d(enu_from_cam, Eigen::Vector3d::Zero());
}

MapMatch ReadMatch(const JsonReader& json, const MapQuery& query, const Rigid3d& global_from_anchor,
                   const std::vector<uint64_t>& tile_ids) {
  MapMatch match;
  match.pixel = {json.At("u").Number(), json.At("v").Number()};
  const std::vector<double> enu = json.At("enu").Numbers(3, 3);
  match.x_in_global = global_from_anchor * Eigen::Vector3d(enu[0], enu[1], enu[2]);
  match.sigma_m = json.At("sigma").Number(0.0, std::numeric_limits<double>::max());
  match.landmark_id = json.At("landmarkId").Integer(0, kMaxExactInteger);
  match.tile_id = tile_ids.at(json.At("tile").Integer(0, kMaxExactInteger));
  const auto keypoint = static_cast<size_t>(json.At("keypoint").Integer(0, kMaxExactInteger));
  if (keypoint < query.track_of_keypoint.size()) {
    match.track_id = query.track_of_keypoint[keypoint];
  }
  return match;
}

Answer ReadAnswer(const JsonReader& json, const MapQuery& query, const Geodetic& global_origin,
                  int max_matches) {
  Answer answer;
  answer.query_id = query.request.query_id;
  answer.localized = json.At("status").String() == "LOCALIZED";
  if (!answer.localized) {
    return answer;
  }
  const Rigid3d global_from_ecef = EcefFromEnu(global_origin).Inverse();
  answer.global_from_cam = ReadPose(json, global_from_ecef);
  std::vector<uint64_t> tile_ids;
  for (const JsonReader& tile :
       json.At("map").At("tiles").Elements(0, kAnswerLimits.max_elements)) {
    tile_ids.push_back(TileId::Parse(tile.String()).value());
  }
  const Rigid3d global_from_anchor =
      global_from_ecef * EcefFromEnu(ReadGeodetic(json.At("anchor")));
  for (const JsonReader& match : json.At("matches").Elements(0, kAnswerLimits.max_elements)) {
    if (std::ssize(answer.matches) == max_matches) {
      break;
    }
    answer.matches.push_back(ReadMatch(match, query, global_from_anchor, tile_ids));
  }
  return answer;
}

}  // namespace

MapRequest MakeMapRequest(const MapQuery& query, const Geodetic& global_origin, int timeout_ms,
                          int max_matches) {
  const bool is_projected = query.features.space == DescriptorSpace::kProjected;
  const WireFeatures wire{.features = query.features,
                          .codec = query.codec,
                          .width_px = query.camera.width_px(),
                          .height_px = query.camera.height_px()};
  const std::vector<uint8_t> bytes = EncodeFeatures(
      wire, {.geometry = GeometryEncoding::kCompact,
             .descriptors = is_projected ? DescriptorEncoding::kFloat16
                                         : LosslessEncoding(query.features).descriptors});
  const std::optional<Geodetic> prior_position = PriorPosition(query, global_origin);
  MultipartWriter writer;
  writer.Add("request", "application/json",
             RequestJson(query, prior_position, timeout_ms, max_matches));
  writer.Add("features", "application/octet-stream",
             {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return {.content_type = MultipartWriter::ContentType(),
          .body = std::move(writer).Finish(),
          .cell = prior_position ? CellName(*prior_position) : ""};
}

std::optional<Answer> ReadMapAnswer(std::string_view json, const MapQuery& query,
                                    const Geodetic& global_origin, int max_matches) noexcept {
  try {
    const JsonDocument document = ParseJson(json, kAnswerLimits);
    return ReadAnswer(JsonReader(document), query, global_origin, max_matches);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace cairn::fusion
