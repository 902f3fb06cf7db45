#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/keypoint_shape.h"
#include "ingest/colmap/colmap_descriptors.h"
#include "ingest/colmap/colmap_ids.h"
#include "ingest/colmap/write_colmap.h"
#include "storage/database/sqlite/connection.h"

namespace cairn {
namespace {

constexpr int kNewFileBusyTimeoutMs = 1000;

// COLMAP's tables without their foreign keys and checks.
constexpr const char* kTables =
    "CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, "
    "model INTEGER NOT NULL, width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB, "
    "prior_focal_length INTEGER NOT NULL);"
    "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, "
    "cols INTEGER NOT NULL, data BLOB);"
    "CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, "
    "cols INTEGER NOT NULL, data BLOB);"
    "CREATE TABLE matches (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, "
    "cols INTEGER NOT NULL, data BLOB);"
    "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY NOT NULL, "
    "rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB, config INTEGER NOT NULL, F BLOB, "
    "E BLOB, H BLOB, qvec BLOB, tvec BLOB);";

std::string TablesOfImages(ColmapGpsTable gps) {
  const std::string images =
      "CREATE TABLE images (image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, "
      "name TEXT NOT NULL UNIQUE, camera_id INTEGER NOT NULL";
  switch (gps) {
    case ColmapGpsTable::kNone:
      break;
    case ColmapGpsTable::kImageColumns:
      return images +
             ", prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL, prior_tx REAL, "
             "prior_ty REAL, prior_tz REAL);";
    case ColmapGpsTable::kPosePriorsOfImages:
      return images +
             ");CREATE TABLE pose_priors (image_id INTEGER PRIMARY KEY NOT NULL, position BLOB, "
             "coordinate_system INTEGER NOT NULL);";
    case ColmapGpsTable::kPosePriorsOfData:
      return images +
             ");CREATE TABLE pose_priors (pose_prior_id INTEGER PRIMARY KEY, corr_data_id "
             "INTEGER, corr_sensor_id INTEGER, corr_sensor_type INTEGER, position BLOB, "
             "coordinate_system INTEGER);";
    case ColmapGpsTable::kPosePriorsWithGravity:
      return images +
             ");CREATE TABLE pose_priors (pose_prior_id INTEGER PRIMARY KEY NOT NULL, corr_data_id "
             "INTEGER NOT NULL, corr_sensor_id INTEGER NOT NULL, corr_sensor_type INTEGER NOT "
             "NULL, position BLOB, position_covariance BLOB, gravity BLOB, coordinate_system "
             "INTEGER NOT NULL);"
             "ALTER TABLE descriptors ADD COLUMN type INTEGER NOT NULL DEFAULT 0;";
  }
  return images + ");";
}

template <typename Value>
std::span<const uint8_t> BytesOf(const std::vector<Value>& values) {
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(Value)};
}

std::vector<float> KeypointRow(const Keypoint& keypoint, int num_columns) {
  // Of a keypoint without shape, COLMAP assumes this scale and orientation, too.
  const float scale_px = HasScale(keypoint) ? keypoint.scale_px : 1.0f;
  const float orientation_rad = HasOrientation(keypoint) ? keypoint.orientation_rad : 0.0f;
  const float c = scale_px * std::cos(orientation_rad);
  const float s = scale_px * std::sin(orientation_rad);
  if (num_columns == 6) {
    return {keypoint.x_px, keypoint.y_px, c, -s, s, c};
  }
  if (num_columns == 4) {
    return {keypoint.x_px, keypoint.y_px, scale_px, orientation_rad};
  }
  return {keypoint.x_px, keypoint.y_px};
}

void WriteCamera(const Camera& camera, int64_t camera_id, sqlite::Connection* database) {
  database->Prepare("INSERT INTO cameras VALUES (?, ?, ?, ?, ?, 1)")
      .Bind(camera_id, static_cast<int64_t>(camera.model()),
            static_cast<int64_t>(camera.width_px()), static_cast<int64_t>(camera.height_px()),
            BytesOf(camera.params()))
      .Run();
}

void WriteFeatures(const FeatureSet& features, int64_t image_id, int keypoint_columns,
                   sqlite::Connection* database) {
  std::vector<float> keypoints;
  for (const Keypoint& keypoint : features.keypoints) {
    for (const float value : KeypointRow(keypoint, keypoint_columns)) {
      keypoints.push_back(value);
    }
  }
  std::vector<uint8_t> descriptors;
  for (int i = 0; i < features.size(); ++i) {
    const float l1_norm = features.descriptors.row(i).lpNorm<1>();
    for (const float value : features.descriptors.row(i)) {
      const float root = std::round(kColmapNorm * std::sqrt(value / l1_norm));
      descriptors.push_back(static_cast<uint8_t>(std::min(255.0f, root)));
    }
  }
  const auto rows = static_cast<int64_t>(features.size());
  database->Prepare("INSERT INTO keypoints VALUES (?, ?, ?, ?)")
      .Bind(image_id, rows, static_cast<int64_t>(keypoint_columns), BytesOf(keypoints))
      .Run();
  database->Prepare("INSERT INTO descriptors (image_id, rows, cols, data) VALUES (?, ?, ?, ?)")
      .Bind(image_id, rows, static_cast<int64_t>(features.descriptors.cols()), BytesOf(descriptors))
      .Run();
}

constexpr int64_t kDataIdOffset = 1000;

// COLMAP 4 writes NaN for what is unknown.
void WritePosePrior(const ReconImage& image, int64_t image_id, sqlite::Connection* database) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> position(3, kUnknown), covariance(9, kUnknown), gravity(3, kUnknown);
  if (image.gps) {
    position = {image.gps->lat_deg(), image.gps->lon_deg(), image.gps->h_m};
  }
  if (image.gps_accuracy_m) {
    // The variance along an axis of a circular Gaussian with 68 % within the accuracy.
    const double variance_sqm = *image.gps_accuracy_m * *image.gps_accuracy_m / -std::log(0.32) / 2;
    covariance = {variance_sqm, 0, 0, 0, variance_sqm, 0, 0, 0, variance_sqm};
  }
  if (image.down_in_cam) {
    gravity.assign(image.down_in_cam->begin(), image.down_in_cam->end());
  }
  database->Prepare("INSERT INTO pose_priors VALUES (?, ?, ?, 0, ?, ?, ?, ?)")
      .Bind(image_id + kDataIdOffset, image_id,
            static_cast<int64_t>(kFirstColmapCameraId) + image.camera_idx, BytesOf(position),
            BytesOf(covariance), BytesOf(gravity), int64_t{image.gps ? 0 : -1})
      .Run();
}

void WriteGps(const Geodetic& gps, int64_t image_id, ColmapGpsTable table,
              sqlite::Connection* database) {
  const std::vector<double> lat_lon_h = {gps.lat_deg(), gps.lon_deg(), gps.h_m};
  switch (table) {
    case ColmapGpsTable::kNone:
    case ColmapGpsTable::kPosePriorsWithGravity:  // WritePosePrior writes it.
      break;
    case ColmapGpsTable::kImageColumns:
      database
          ->Prepare("UPDATE images SET prior_tx = ?, prior_ty = ?, prior_tz = ? WHERE image_id = ?")
          .Bind(lat_lon_h[0], lat_lon_h[1], lat_lon_h[2], image_id)
          .Run();
      break;
    case ColmapGpsTable::kPosePriorsOfImages:
      database->Prepare("INSERT INTO pose_priors VALUES (?, ?, 0)")
          .Bind(image_id, BytesOf(lat_lon_h))
          .Run();
      break;
    case ColmapGpsTable::kPosePriorsOfData:
      database->Prepare("INSERT INTO pose_priors VALUES (?, ?, 1, 0, ?, 0)")
          .Bind(image_id + kDataIdOffset, image_id, BytesOf(lat_lon_h))
          .Run();
      break;
  }
}

}  // namespace

void WriteColmapDatabase(const Reconstruction& reconstruction, const std::string& path,
                         const ColmapDatabaseOptions& options) {
  sqlite::Connection database(path, sqlite::Access::kCreate, kNewFileBusyTimeoutMs);
  database.Execute(kTables + TablesOfImages(options.gps));
  database.Execute("BEGIN");
  for (size_t i = 0; i < reconstruction.cameras.size(); ++i) {
    WriteCamera(reconstruction.cameras[i], static_cast<int64_t>(kFirstColmapCameraId + i),
                &database);
  }
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    const ReconImage& image = reconstruction.images[i];
    const auto image_id = static_cast<int64_t>(kFirstColmapImageId + i);
    database.Prepare("INSERT INTO images (image_id, name, camera_id) VALUES (?, ?, ?)")
        .Bind(image_id, std::string_view(image.name),
              static_cast<int64_t>(kFirstColmapCameraId) + image.camera_idx)
        .Run();
    WriteFeatures(image.features.Unpacked(), image_id, options.keypoint_columns, &database);
    if (options.gps == ColmapGpsTable::kPosePriorsWithGravity) {
      WritePosePrior(image, image_id, &database);
    } else if (image.gps) {
      WriteGps(*image.gps, image_id, options.gps, &database);
    }
  }
  database.Execute("COMMIT");
}

}  // namespace cairn
