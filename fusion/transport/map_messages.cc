#include "fusion/transport/map_messages.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/tile_id.h"
#include "http/wire/feature_codec.h"
#include "http/wire/multipart.h"

namespace cairn::fusion {
namespace {

using Json = nlohmann::json;

// Radius of the disk that holds 68 % of an isotropic Gaussian of unit variance in the plane.
constexpr double kRadiusPerSigma = 1.51;
// The filter's accuracy may be finer than the server's search grid, so it is limited to this value.
constexpr double kMinAccuracyM = 1.0;

Json PriorJson(const Geodetic& position, double accuracy_m) {
  return {
      {"position", {{"lat", position.lat_deg()}, {"lon", position.lon_deg()}, {"h", position.h_m}}},
      {"accuracy", accuracy_m}};
}

// The prior of the camera's position: the filter's, or else the receiver's.
std::optional<Json> PriorOf(const MapQuery& query, const Geodetic& global_origin) {
  if (const auto& prior = query.query.prior) {
    const Eigen::Matrix3d covariance = prior->covariance.bottomRightCorner<3, 3>();
    const double horizontal = std::max(covariance(0, 0), covariance(1, 1));
    const Geodetic position =
        GeodeticFromEcef(EcefFromEnu(global_origin) * prior->global_from_cam.translation);
    Json json =
        PriorJson(position, std::max(kMinAccuracyM, kRadiusPerSigma * std::sqrt(horizontal)));
    json["altitudeAccuracy"] = std::max(kMinAccuracyM, std::sqrt(covariance(2, 2)));
    return json;
  }
  if (query.rough_position) {
    return PriorJson(query.rough_position->position, query.rough_position->accuracy_m);
  }
  return std::nullopt;
}

std::string RequestJson(const MapQuery& query, const Geodetic& global_origin, int timeout_ms,
                        int max_matches) {
  const Eigen::Vector3d& down = query.query.down_in_cam;
  Json json = {{"id", std::to_string(query.query.query_id)},
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
  if (auto prior = PriorOf(query, global_origin)) {
    json["prior"] = std::move(*prior);
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

double Finite(const Json& json) {
  const auto value = json.get<double>();
  if (!std::isfinite(value)) {
    throw std::invalid_argument("a number is not finite");
  }
  return value;
}

Geodetic ReadGeodetic(const Json& json) {
  const Geodetic position =
      Geodetic::FromDegrees(Finite(json.at("lat")), Finite(json.at("lon")), Finite(json.at("h")));
  ValidateGeodetic(position, "position");
  return position;
}

Rigid3d ReadPose(const Json& json, const Rigid3d& global_from_ecef) {
  if (json.at("innerFrame").get<std::string>() != "RDF") {
    throw std::invalid_argument("another inner frame than asked for");
  }
  const Json& q = json.at("geopose").at("quaternion");
  const Eigen::Quaterniond enu_from_cam(Finite(q.at("w")), Finite(q.at("x")), Finite(q.at("y")),
                                        Finite(q.at("z")));
  if (std::abs(enu_from_cam.norm() - 1.0) > 1e-3) {
    throw std::invalid_argument("the quaternion is not of unit length");
  }
  const Rigid3d ecef_from_enu = EcefFromEnu(ReadGeodetic(json.at("geopose").at("position")));
  return global_from_ecef * ecef_from_enu * Rigid3d(enu_from_cam, Eigen::Vector3d::Zero());
}

MapMatch ReadMatch(const Json& json, const MapQuery& query, const Rigid3d& global_from_anchor,
                   const std::vector<uint64_t>& tile_ids) {
  MapMatch match;
  match.pixel = {Finite(json.at("u")), Finite(json.at("v"))};
  const Json& enu = json.at("enu");
  match.x_in_global =
      global_from_anchor * Eigen::Vector3d(Finite(enu.at(0)), Finite(enu.at(1)), Finite(enu.at(2)));
  match.sigma_m = Finite(json.at("sigma"));
  if (match.sigma_m < 0.0) {
    throw std::invalid_argument("a standard deviation is negative");
  }
  match.landmark_id = json.at("landmarkId").get<uint64_t>();
  match.tile_id = tile_ids.at(json.at("tile").get<size_t>());
  const auto keypoint = json.at("keypoint").get<size_t>();
  if (keypoint < query.track_of_keypoint.size()) {
    match.track_id = query.track_of_keypoint[keypoint];
  }
  return match;
}

Answer ReadAnswer(const Json& json, const MapQuery& query, const Geodetic& global_origin) {
  Answer answer;
  answer.query_id = query.query.query_id;
  answer.localized = json.at("status").get<std::string>() == "LOCALIZED";
  if (!answer.localized) {
    return answer;
  }
  const Rigid3d global_from_ecef = EcefFromEnu(global_origin).Inverse();
  answer.global_from_cam = ReadPose(json, global_from_ecef);
  std::vector<uint64_t> tile_ids;
  for (const Json& tile : json.at("map").at("tiles")) {
    tile_ids.push_back(TileId::Parse(tile.get<std::string>()).value());
  }
  const Rigid3d global_from_anchor =
      global_from_ecef * EcefFromEnu(ReadGeodetic(json.at("anchor")));
  for (const Json& match : json.at("matches")) {
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
  MultipartWriter writer;
  writer.Add("request", "application/json",
             RequestJson(query, global_origin, timeout_ms, max_matches));
  writer.Add("features", "application/octet-stream",
             {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return {MultipartWriter::ContentType(), std::move(writer).Finish()};
}

std::optional<Answer> ReadMapAnswer(std::string_view json, const MapQuery& query,
                                    const Geodetic& global_origin) noexcept {
  try {
    return ReadAnswer(Json::parse(json), query, global_origin);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace cairn::fusion
