#include "fusion/transport/map_messages.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/cell_name.h"
#include "core/radius68.h"
#include "core/tile_id.h"
#include "core/wire/feature_codec.h"
#include "core/wire/multipart.h"
#include "core/wire/wire_request.h"
#include "core/wire/wire_response.h"

namespace cairn::fusion {
namespace {

// The filter's accuracy may be finer than the server's search grid, so it is limited to this value.
constexpr double kMinAccuracyM = 1.0;

// The position of the prior: the filter's, or else the receiver's.
std::optional<Geodetic> PriorPosition(const MapQuery& query, const Geodetic& global_origin) {
  if (const auto& prior = query.request.prior) {
    return GeodeticFromEcef(EcefFromEnu(global_origin) * prior->global_from_cam.translation);
  }
  return query.rough_position ? std::optional(query.rough_position->position) : std::nullopt;
}

// The prior of the camera's position at `position`, which PriorPosition returned.
PositionPrior PriorOf(const MapQuery& query, const Geodetic& position) {
  if (const auto& prior = query.request.prior) {
    const Eigen::Matrix3d covariance = prior->covariance.bottomRightCorner<3, 3>();
    const double horizontal = std::max(covariance(0, 0), covariance(1, 1));
    return {.position = position,
            .accuracy_m = std::max(kMinAccuracyM, kRadius68PerSigma2d * std::sqrt(horizontal)),
            .height_sigma_m = std::max(kMinAccuracyM, std::sqrt(covariance(2, 2)))};
  }
  return {.position = position, .accuracy_m = query.rough_position->accuracy_m};
}

std::string RequestJson(const MapQuery& query, const std::optional<Geodetic>& prior_position,
                        int timeout_ms, int max_matches) {
  WireRequest wire{.id = std::to_string(query.request.query_id),
                   .camera = query.camera,
                   .down_in_cam = query.request.down_in_cam,
                   .timeout_ms = timeout_ms,
                   .answer = {.inner_frame = InnerFrame::kRdf,
                              .max_matches = max_matches,
                              .with_matches = true,
                              .with_timings = false,
                              .with_covariance = false}};
  if (prior_position) {
    wire.prior = PriorOf(query, *prior_position);
  }
  return WireRequestJson(wire);
}

MapMatch MatchOf(const WireMatch& wire, const MapQuery& query, const Rigid3d& global_from_anchor,
                 const std::vector<TileId>& tiles) {
  MapMatch match;
  match.pixel = wire.pixel;
  match.x_in_global = global_from_anchor * wire.x_in_anchor;
  match.sigma_m = wire.sigma_m;
  match.landmark_id = wire.landmark_id;
  match.tile_id = tiles[wire.tile_idx].value();
  const auto keypoint = static_cast<size_t>(wire.keypoint_idx);
  if (keypoint < query.track_of_keypoint.size()) {
    match.track_id = query.track_of_keypoint[keypoint];
  }
  return match;
}

// Returns nothing if the server left out what it was asked for.
std::optional<Answer> AnswerOf(const WireResponse& wire, const MapQuery& query,
                               const Geodetic& global_origin, int max_matches) {
  Answer answer;
  answer.query_id = query.request.query_id;
  answer.localized = wire.pose.has_value();
  if (!answer.localized) {
    return answer;
  }
  if (wire.pose->inner_frame != InnerFrame::kRdf || !wire.matches) {
    return std::nullopt;
  }
  const Rigid3d global_from_ecef = EcefFromEnu(global_origin).Inverse();
  const GeoPose& geopose = wire.pose->geopose;  // RDF is the frame of the camera.
  answer.global_from_cam = global_from_ecef * EcefFromEnu(geopose.position) *
                           Rigid3d(geopose.enu_from_inner, Eigen::Vector3d::Zero());
  const Rigid3d global_from_anchor = global_from_ecef * EcefFromEnu(wire.pose->anchor);
  for (const WireMatch& match : *wire.matches) {
    if (std::ssize(answer.matches) == max_matches) {
      break;
    }
    answer.matches.push_back(MatchOf(match, query, global_from_anchor, wire.tiles));
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
    return AnswerOf(ReadWireResponse(JsonReader(document)), query, global_origin, max_matches);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace cairn::fusion
