// Writes reconstructions the way COLMAP does, for the reader to read.
#ifndef CAIRN_TESTS_SUPPORT_COLMAP_WRITER_H_
#define CAIRN_TESTS_SUPPORT_COLMAP_WRITER_H_

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "ingest/reconstruction.h"
#include "storage/sqlite/connection.h"

namespace cairn::testing {

// COLMAP's ids start at 1; ours here are the index plus this, so that mix-ups show.
inline constexpr uint32_t kFirstCameraId = 3;
inline constexpr uint32_t kFirstImageId = 11;

inline void WriteBinaryColmapModel(const Reconstruction& reconstruction, const std::string& dir) {
  const auto put = [](std::ofstream* file, auto value) {
    file->write(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  std::ofstream cameras(dir + "/cameras.bin", std::ios::binary);
  put(&cameras, static_cast<uint64_t>(reconstruction.cameras.size()));
  for (size_t i = 0; i < reconstruction.cameras.size(); ++i) {
    const Camera& camera = reconstruction.cameras[i];
    put(&cameras, static_cast<uint32_t>(kFirstCameraId + i));
    put(&cameras, static_cast<int32_t>(camera.model()));
    put(&cameras, static_cast<uint64_t>(camera.width_px()));
    put(&cameras, static_cast<uint64_t>(camera.height_px()));
    for (const double param : camera.params()) put(&cameras, param);
  }
  std::ofstream images(dir + "/images.bin", std::ios::binary);
  put(&images, static_cast<uint64_t>(reconstruction.images.size()));
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    const ReconImage& image = reconstruction.images[i];
    put(&images, static_cast<uint32_t>(kFirstImageId + i));
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) put(&images, value);
    for (const double value : image.cam_from_world.translation) put(&images, value);
    put(&images, static_cast<uint32_t>(kFirstCameraId + image.camera_idx));
    images.write(image.name.c_str(), static_cast<std::streamsize>(image.name.size() + 1));
    put(&images, static_cast<uint64_t>(image.features.keypoints.size()));
    for (const Keypoint& keypoint : image.features.keypoints) {
      put(&images, static_cast<double>(keypoint.x_px));
      put(&images, static_cast<double>(keypoint.y_px));
      put(&images, int64_t{-1});
    }
  }
  std::ofstream points(dir + "/points3D.bin", std::ios::binary);
  put(&points, static_cast<uint64_t>(reconstruction.landmarks.size()));
  for (size_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    const ReconLandmark& landmark = reconstruction.landmarks[i];
    put(&points, static_cast<uint64_t>(i + 1));
    for (const double value : landmark.x_in_world) put(&points, value);
    for (int k = 0; k < 3; ++k) put(&points, uint8_t{128});
    put(&points, 0.5);
    put(&points, static_cast<uint64_t>(landmark.observations.size()));
    for (const ReconObservation& observation : landmark.observations) {
      put(&points, static_cast<uint32_t>(kFirstImageId + observation.image_idx));
      put(&points, static_cast<uint32_t>(observation.keypoint_idx));
    }
  }
}

inline void WriteTextColmapModel(const Reconstruction& reconstruction, const std::string& dir) {
  std::ofstream cameras(dir + "/cameras.txt"), images(dir + "/images.txt"),
      points(dir + "/points3D.txt");
  for (std::ofstream* file : {&cameras, &images, &points}) {
    file->precision(17);
    *file << "# Made for a test\n";
  }
  for (size_t i = 0; i < reconstruction.cameras.size(); ++i) {
    const Camera& camera = reconstruction.cameras[i];
    cameras << kFirstCameraId + i << ' ' << CameraModelName(camera.model()) << ' '
            << camera.width_px() << ' ' << camera.height_px();
    for (const double param : camera.params()) cameras << ' ' << param;
    cameras << '\n';
  }
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    const ReconImage& image = reconstruction.images[i];
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    images << kFirstImageId + i << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z()
           << ' ' << image.cam_from_world.translation.transpose() << ' '
           << kFirstCameraId + image.camera_idx << ' ' << image.name << '\n';
    for (const Keypoint& keypoint : image.features.keypoints) {
      images << keypoint.x_px << ' ' << keypoint.y_px << " -1 ";
    }
    images << '\n';
  }
  for (size_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    const ReconLandmark& landmark = reconstruction.landmarks[i];
    points << i + 1 << ' ' << landmark.x_in_world.transpose() << " 128 128 128 0.5";
    for (const ReconObservation& observation : landmark.observations) {
      points << ' ' << kFirstImageId + observation.image_idx << ' ' << observation.keypoint_idx;
    }
    points << '\n';
  }
}

enum class GpsTable { kNone, kImageColumns, kPosePriorsOfImages, kPosePriorsOfData };

struct ColmapDatabaseOptions {
  int keypoint_columns = 6;  // 2, 4 or 6.
  GpsTable gps = GpsTable::kImageColumns;
};

inline std::vector<float> KeypointRow(const Keypoint& keypoint, int num_columns) {
  const float c = keypoint.scale_px * std::cos(keypoint.orientation_rad);
  const float s = keypoint.scale_px * std::sin(keypoint.orientation_rad);
  if (num_columns == 6) return {keypoint.x_px, keypoint.y_px, c, -s, s, c};
  if (num_columns == 4) {
    return {keypoint.x_px, keypoint.y_px, keypoint.scale_px, keypoint.orientation_rad};
  }
  return {keypoint.x_px, keypoint.y_px};
}

inline void WriteColmapFeatures(const FeatureSet& features, int64_t image_id, int keypoint_columns,
                                sqlite::Connection* database) {
  std::vector<float> keypoints;
  for (const Keypoint& keypoint : features.keypoints) {
    for (const float value : KeypointRow(keypoint, keypoint_columns)) keypoints.push_back(value);
  }
  std::vector<uint8_t> descriptors;
  for (int i = 0; i < features.size(); ++i) {
    const float l1_norm = features.descriptors.row(i).lpNorm<1>();
    for (const float value : features.descriptors.row(i)) {
      descriptors.push_back(
          static_cast<uint8_t>(std::min(255.0f, std::round(512.0f * std::sqrt(value / l1_norm)))));
    }
  }
  const auto* bytes = reinterpret_cast<const uint8_t*>(keypoints.data());
  const auto rows = static_cast<int64_t>(features.size());
  database->Prepare("INSERT INTO keypoints VALUES (?, ?, ?, ?)")
      .Bind(image_id, rows, static_cast<int64_t>(keypoint_columns),
            std::span<const uint8_t>(bytes, keypoints.size() * sizeof(float)))
      .Run();
  database->Prepare("INSERT INTO descriptors VALUES (?, ?, ?, ?)")
      .Bind(image_id, rows, static_cast<int64_t>(features.descriptors.cols()),
            std::span<const uint8_t>(descriptors))
      .Run();
}

inline void WriteColmapGps(const Geodetic& gps, int64_t image_id, GpsTable table,
                           sqlite::Connection* database) {
  const double lat_lon_h[3] = {gps.lat_deg(), gps.lon_deg(), gps.h_m};
  const std::span<const uint8_t> blob(reinterpret_cast<const uint8_t*>(lat_lon_h),
                                      sizeof(lat_lon_h));
  if (table == GpsTable::kImageColumns) {
    database
        ->Prepare("UPDATE images SET prior_tx = ?, prior_ty = ?, prior_tz = ? WHERE image_id = ?")
        .Bind(lat_lon_h[0], lat_lon_h[1], lat_lon_h[2], image_id)
        .Run();
  } else if (table == GpsTable::kPosePriorsOfImages) {
    database->Prepare("INSERT INTO pose_priors VALUES (?, ?, 0)").Bind(image_id, blob).Run();
  } else if (table == GpsTable::kPosePriorsOfData) {
    database->Prepare("INSERT INTO pose_priors VALUES (?, ?, 1, 0, ?, 0)")
        .Bind(image_id + 1000, image_id, blob)
        .Run();
  }
}

inline void WriteColmapDatabase(const Reconstruction& reconstruction, const std::string& path,
                                const ColmapDatabaseOptions& options = {}) {
  sqlite::Connection database(path, sqlite::Access::kCreate, 1000);
  database.Execute(
      "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, "
      "camera_id INTEGER NOT NULL" +
      std::string(options.gps == GpsTable::kImageColumns
                      ? ", prior_tx REAL, prior_ty REAL, prior_tz REAL);"
                      : ");") +
      "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data "
      "BLOB);"
      "CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, "
      "data BLOB);");
  if (options.gps == GpsTable::kPosePriorsOfImages) {
    database.Execute(
        "CREATE TABLE pose_priors (image_id INTEGER PRIMARY KEY, position BLOB, "
        "coordinate_system INTEGER)");
  } else if (options.gps == GpsTable::kPosePriorsOfData) {
    database.Execute(
        "CREATE TABLE pose_priors (pose_prior_id INTEGER PRIMARY KEY, corr_data_id INTEGER, "
        "corr_sensor_id INTEGER, corr_sensor_type INTEGER, position BLOB, "
        "coordinate_system INTEGER)");
  }
  database.Execute("BEGIN");
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    const ReconImage& image = reconstruction.images[i];
    const auto image_id = static_cast<int64_t>(kFirstImageId + i);
    database.Prepare("INSERT INTO images (image_id, name, camera_id) VALUES (?, ?, ?)")
        .Bind(image_id, std::string_view(image.name),
              static_cast<int64_t>(kFirstCameraId + image.camera_idx))
        .Run();
    WriteColmapFeatures(image.features, image_id, options.keypoint_columns, &database);
    if (image.gps) WriteColmapGps(*image.gps, image_id, options.gps, &database);
  }
  database.Execute("COMMIT");
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_COLMAP_WRITER_H_
