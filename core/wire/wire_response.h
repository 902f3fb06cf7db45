// The response to POST /v1/localize as JSON, in both directions. The server writes it, and the
// clients read it.
#ifndef CAIRN_CORE_WIRE_WIRE_RESPONSE_H_
#define CAIRN_CORE_WIRE_WIRE_RESPONSE_H_

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/focal_length.h"
#include "core/geodesy.h"
#include "core/position_prior.h"
#include "core/tile_id.h"
#include "core/wire/inner_frame.h"
#include "core/wire/json_reader.h"
#include "core/wire/wire_request.h"

namespace cairn {

// An inlier of the pose.
struct WireMatch {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  uint64_t landmark_id = 0;  // At most kMaxExactInteger.
  Eigen::Vector3d x_in_anchor = Eigen::Vector3d::Zero();
  double sigma_m = 0.0;  // Landmark position standard deviation; not negative.
  double error_px = 0.0;
  double right_probability = 0.0;
  int keypoint_idx = 0;  // Into the features of its camera; may be outside them.
  int tile_idx = 0;      // Into WireResponse::tiles.
  int camera_idx = 0;    // 0 is the request's own camera, i is other_cameras[i - 1].
};

// Radii that hold the truth with 68 % probability.
struct WireAccuracy {
  double position_m = 0.0;
  double rotation_rad = 0.0;  // Degrees on the wire.
};

// What a response says of a pose.
struct WirePose {
  GeoPose geopose = {};
  InnerFrame inner_frame = InnerFrame::kFlu;           // Of `geopose`.
  Geodetic anchor = {};                                // Origin of the anchor frame, east-north-up.
  WireAccuracy accuracy = {};                          // In the map.
  std::optional<WireAccuracy> accuracy_on_earth = {};  // Older servers do not send it.
  // Of (translation, rotation) in the east-north-up frame at the camera.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance = {};
  std::optional<CameraEstimate> camera = {};
  double confidence = 0.0;
  double score = 0.0;
  double false_alarm_rate = 0.0;
  bool prior_disagrees = false;
  int64_t num_inliers = 0;  // `matches` may have fewer.
};

// A response without the counters and times of the engine's stages.
struct WireResponse {
  std::string id = {};
  std::optional<int64_t> timestamp_ms = {};
  std::optional<WirePose> pose = {};  // Nothing if the query was not localized.
  // Of a query that was not localized: the reason's name, and the same in words if known.
  std::string reason = {}, reason_text = {};
  // The prior that the answer is based on. Without `height_sigma_m`.
  std::optional<PositionPrior> prior = {};
  bool is_upright = false;                             // The server turned the picture by its EXIF.
  std::optional<std::vector<WireMatch>> matches = {};  // With a pose, if asked for.
  int64_t map_version = 0;
  bool map_is_stale = false;
  std::vector<TileId> tiles = {};
};

// Returns the members; the caller may add others. Text may hold bytes that are not UTF-8.
nlohmann::ordered_json WireResponseJson(const WireResponse& response);

// Reads also responses of older servers, without members that describe a pose or a match but do not
// place them. Throws JsonError with the pointer of the member at fault, and Error(kBadInput) if the
// name of a tile is malformed. Numbers have the ranges that the structures state.
WireResponse ReadWireResponse(const JsonReader& json);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_WIRE_RESPONSE_H_
