#include "ingest/colmap/colmap_pose_priors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/logging.h"
#include "core/printable.h"
#include "ingest/colmap/colmap_columns.h"
#include "storage/database/sqlite/connection.h"

namespace cairn {
namespace {

using Priors = std::unordered_map<std::string, ColmapPosePrior>;

// COLMAP's PosePrior::CoordinateSystem and SensorType::CAMERA.
constexpr int64_t kWgs84 = 0;
constexpr int64_t kCameraSensor = 0;

// No receiver is better; a smaller value is no standard deviation in meters.
constexpr double kMinAccuracyM = 1e-3;
// A gravity vector is a direction or an acceleration.
constexpr double kMinGravity = 1e-3;

// Returns N doubles of a blob. Returns nothing if the column has none.
template <size_t N>
std::optional<std::array<double, N>> Doubles(const sqlite::Statement& row, int column) {
  std::array<double, N> values;
  if (row.IsNull(column)) {
    return std::nullopt;
  }
  const std::vector<uint8_t> blob = row.Blob(column);
  if (blob.size() != sizeof(values)) {
    return std::nullopt;
  }
  std::memcpy(values.data(), blob.data(), sizeof(values));
  return values;
}

// Positions that do not count.
struct LeftOut {
  int64_t num_of_other_systems = 0;
  int64_t num_impossible = 0;
  std::string example;  // Of the impossible ones.
};

// A height that no place has is brought to the limits of Geodetic, where it is none
// (CheckPositions).
std::optional<Geodetic> PlaceAt(const std::array<double, 3>& position, const std::string& name,
                                LeftOut* left_out) {
  const auto [lat_deg, lon_deg, h_m] = position;
  const bool is_unknown =
      (std::isnan(lat_deg) && std::isnan(lon_deg)) || (lat_deg == 0.0 && lon_deg == 0.0);
  if (is_unknown) {
    return std::nullopt;
  }
  if (!(std::abs(lat_deg) <= 90.0 && std::abs(lon_deg) <= 180.0)) {
    if (left_out->num_impossible++ == 0) {
      left_out->example = fmt::format("{}, {} of {}", lat_deg, lon_deg, Excerpt(name));
    }
    return std::nullopt;
  }
  return Geodetic::FromDegrees(
      lat_deg, lon_deg,
      std::isnan(h_m) ? 0.0 : std::clamp(h_m, Geodetic::kMinHeightM, Geodetic::kMaxHeightM));
}

// Returns the radius that holds 68 % of a circular Gaussian with the mean variance of east and
// north. The covariance is symmetric, so its order in memory does not matter.
std::optional<double> AccuracyOf(const std::array<double, 9>& covariance) {
  const double radius_m = std::sqrt(-std::log(0.32) * (covariance[0] + covariance[4]));
  if (!(std::isfinite(radius_m) && radius_m >= kMinAccuracyM)) {
    return std::nullopt;
  }
  return radius_m;
}

std::optional<Eigen::Vector3d> DirectionOf(const std::array<double, 3>& gravity) {
  const Eigen::Vector3d vector(gravity.data());
  const double length = vector.norm();
  if (!(std::isfinite(length) && length >= kMinGravity)) {
    return std::nullopt;
  }
  return vector / length;
}

// Fills what `prior` lacks from a row of `pose_priors`: name, coordinate system, position,
// covariance, gravity.
void AddRow(const sqlite::Statement& row, ColmapPosePrior* prior, LeftOut* left_out) {
  if (const auto gravity = Doubles<3>(row, 4); gravity && !prior->down_in_cam) {
    prior->down_in_cam = DirectionOf(*gravity);
  }
  const auto position = Doubles<3>(row, 2);
  if (!position || std::isnan((*position)[0])) {
    return;
  }
  if (row.Int64(1) != kWgs84) {
    ++left_out->num_of_other_systems;
    return;
  }
  if (!prior->gps) {
    prior->gps = PlaceAt(*position, row.Text(0), left_out);
    const auto covariance = Doubles<9>(row, 3);
    prior->gps_accuracy_m = prior->gps && covariance ? AccuracyOf(*covariance) : std::nullopt;
  }
}

void ReadTable(sqlite::Connection* connection, Priors* priors, LeftOut* left_out) {
  const auto column = [&](const char* name) {
    return HasColumn(connection, "pose_priors", name) ? fmt::format("p.{}", name) : "NULL";
  };
  const bool by_datum = HasColumn(connection, "pose_priors", "corr_data_id");
  if (!by_datum && !HasColumn(connection, "pose_priors", "image_id")) {
    return;
  }
  sqlite::Statement row = connection->Prepare(fmt::format(
      "SELECT i.name, p.coordinate_system, p.position, {}, {} FROM pose_priors AS p "
      "JOIN images AS i ON i.image_id = p.{}",
      column("position_covariance"), column("gravity"),
      by_datum ? fmt::format("corr_data_id WHERE p.corr_sensor_type = {} ORDER BY p.pose_prior_id",
                             kCameraSensor)
               : std::string("image_id")));
  while (row.Step()) {
    AddRow(row, &(*priors)[row.Text(0)], left_out);
  }
}

void ReadColumns(sqlite::Connection* connection, Priors* priors, LeftOut* left_out) {
  if (!HasColumn(connection, "images", "prior_tx")) {
    return;
  }
  sqlite::Statement row = connection->Prepare(
      "SELECT name, prior_tx, prior_ty, prior_tz FROM images WHERE prior_tx IS NOT NULL AND "
      "prior_ty IS NOT NULL");
  while (row.Step()) {
    std::optional<Geodetic>& gps = (*priors)[row.Text(0)].gps;
    if (!gps) {
      gps = PlaceAt({row.Number(1), row.Number(2), row.IsNull(3) ? 0.0 : row.Number(3)},
                    row.Text(0), left_out);
    }
  }
}

void LogLeftOut(const std::string& path, const LeftOut& left_out) {
  if (left_out.num_of_other_systems > 0) {
    LogWarning(
        "COLMAP database {}: {} of its positions are ignored because their coordinate system "
        "is not WGS84",
        path, left_out.num_of_other_systems);
  }
  if (left_out.num_impossible > 0) {
    LogWarning(
        "COLMAP database {}: {} of its positions are ignored because they are no latitude and "
        "longitude in degrees, e.g. {}",
        path, left_out.num_impossible, left_out.example);
  }
}

}  // namespace

std::unordered_map<std::string, ColmapPosePrior> ReadColmapPosePriors(
    const std::string& path, sqlite::Connection* connection) {
  Priors priors;
  LeftOut left_out;
  ReadTable(connection, &priors, &left_out);
  ReadColumns(connection, &priors, &left_out);
  LogLeftOut(path, left_out);
  return priors;
}

}  // namespace cairn
