#include "ingest/colmap/colmap_pose_priors.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/logging.h"
#include "ingest/colmap/colmap_columns.h"
#include "storage/database/sqlite/connection.h"

namespace cairn {
namespace {

using Priors = std::unordered_map<std::string, ColmapPosePrior>;

// COLMAP's PosePrior::CoordinateSystem and SensorType::CAMERA.
constexpr int64_t kWgs84 = 0;
constexpr int64_t kCameraSensor = 0;

constexpr double kMaxHeightM = 12'000.0;
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

std::optional<Geodetic> PlaceAt(double lat_deg, double lon_deg, double h_m) {
  const double known_h_m = std::isnan(h_m) ? 0.0 : h_m;
  const bool is_place = std::abs(lat_deg) <= 90.0 && std::abs(lon_deg) <= 180.0 &&
                        std::abs(known_h_m) <= kMaxHeightM && (lat_deg != 0.0 || lon_deg != 0.0);
  if (!is_place) {
    return std::nullopt;
  }
  return Geodetic::FromDegrees(lat_deg, lon_deg, known_h_m);
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
// covariance, gravity. Returns false if the row has a position of another coordinate system.
bool AddRow(const sqlite::Statement& row, ColmapPosePrior* prior) {
  if (const auto gravity = Doubles<3>(row, 4); gravity && !prior->down_in_cam) {
    prior->down_in_cam = DirectionOf(*gravity);
  }
  const auto position = Doubles<3>(row, 2);
  if (!position || std::isnan((*position)[0])) {
    return true;
  }
  if (row.Int64(1) != kWgs84) {
    return false;
  }
  if (!prior->gps) {
    const auto [lat_deg, lon_deg, h_m] = *position;
    prior->gps = PlaceAt(lat_deg, lon_deg, h_m);
    const auto covariance = Doubles<9>(row, 3);
    prior->gps_accuracy_m = prior->gps && covariance ? AccuracyOf(*covariance) : std::nullopt;
  }
  return true;
}

void ReadTable(const std::string& path, sqlite::Connection* connection, Priors* priors) {
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
  int64_t num_others = 0;
  while (row.Step()) {
    num_others += AddRow(row, &(*priors)[row.Text(0)]) ? 0 : 1;
  }
  if (num_others > 0) {
    LogWarning(
        "COLMAP database {}: {} of its positions are ignored because their coordinate system "
        "is not WGS84",
        path, num_others);
  }
}

void ReadColumns(sqlite::Connection* connection, Priors* priors) {
  if (!HasColumn(connection, "images", "prior_tx")) {
    return;
  }
  sqlite::Statement row = connection->Prepare(
      "SELECT name, prior_tx, prior_ty, prior_tz FROM images WHERE prior_tx IS NOT NULL AND "
      "prior_ty IS NOT NULL");
  while (row.Step()) {
    std::optional<Geodetic>& gps = (*priors)[row.Text(0)].gps;
    if (!gps) {
      gps = PlaceAt(row.Number(1), row.Number(2), row.IsNull(3) ? 0.0 : row.Number(3));
    }
  }
}

}  // namespace

std::unordered_map<std::string, ColmapPosePrior> ReadColmapPosePriors(
    const std::string& path, sqlite::Connection* connection) {
  Priors priors;
  ReadTable(path, connection, &priors);
  ReadColumns(connection, &priors);
  return priors;
}

}  // namespace cairn
