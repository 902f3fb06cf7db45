// Writes a small street for the tests of the Python package:
// make_street DIR [--photos | --frames POSES].
//
//   DIR/colmap/         a model and a database with GPS, for cairn.ingest
//   DIR/queries.json    queries with features and true poses, for cairn.evaluate
//   DIR/keypoints.f32, descriptors.f32, query.txt
//                       the features of the first query; its size, intrinsics, rough position,
//                       gravity and true position (ECEF)
//   DIR/photos/, positions.csv
//                       rendered photos and their positions, for cairn.map; only with --photos
//   DIR/0.keypoints.f32, 0.descriptors.f32, 0.landmarks.i32, ...
//                       instead of all that, with --frames: what the cameras of the file POSES see;
//                       each of its lines is a 3 x 4 matrix from enu to the camera
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "cli/demo/street/street_scene.h"
#include "cli/query_features.h"
#include "core/angles.h"
#include "core/error.h"
#include "eval/eval_query.h"
#include "eval/pictures/encode_png.h"
#include "ingest/colmap/write_colmap.h"
#include "support/reconstruction_builder.h"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

constexpr int kNumQueries = 4;

void Write(const fs::path& path, const void* data, size_t num_bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(static_cast<const char*>(data), static_cast<std::streamsize>(num_bytes));
  if (!file.flush()) {
    throw Error(ErrorCode::kIo, path.string() + ": cannot write");
  }
}

void WriteText(const fs::path& path, const std::string& text) {
  Write(path, text.data(), text.size());
}

std::vector<EvalQuery> MakeQueries(const StreetWorld& street) {
  const Rigid3d enu_from_ecef = EcefFromEnu(street.options().origin).Inverse();
  std::vector<EvalQuery> queries;
  for (int i = 0; i < kNumQueries; ++i) {
    const Rigid3d cam_from_enu =
        StreetWorld::LookAlong({10.0 + 7.0 * i, 0.4, 1.5}, 0.3 * (i % 2) - 0.1);
    EvalQuery query;
    query.name = fmt::format("query{}", i);
    query.query.camera = street.camera();
    query.query.features = street.Photograph(cam_from_enu, 77 + i);
    query.cam_from_ecef = cam_from_enu * enu_from_ecef;
    queries.push_back(std::move(query));
  }
  AddNoisyPriors({}, &queries);
  return queries;
}

void WriteFirst(const EvalQuery& first, const fs::path& dir) {
  const FeatureSet& features = first.query.features;
  Write(dir / "keypoints.f32", features.keypoints.data(),
        features.keypoints.size() * sizeof(Keypoint));
  Write(dir / "descriptors.f32", features.descriptors.data(),
        static_cast<size_t>(features.descriptors.size()) * sizeof(float));
  const Camera& camera = first.query.camera;
  const Geodetic& prior = first.query.prior->position;
  const Eigen::Vector3d& down = *first.query.down_in_cam;
  const Eigen::Vector3d center = first.cam_from_ecef.Inverse().translation;
  WriteText(
      dir / "query.txt",
      fmt::format("{} {}\n{} {} {} {}\n{:.9f} {:.9f} {:.3f}\n{} {} {}\n{:.4f} {:.4f} {:.4f}\n",
                  camera.width_px(), camera.height_px(), camera.params()[0], camera.params()[1],
                  camera.params()[2], camera.params()[3], prior.lat_deg(), prior.lon_deg(),
                  prior.h_m, down.x(), down.y(), down.z(), center.x(), center.y(), center.z()));
}

// A walk along one side of a rendered street, a step of a meter and a half between photos.
void WritePhotos(const fs::path& dir) {
  StreetOptions options;
  options.length_m = 40.0;
  options.image_width_px = 480;
  options.image_height_px = 360;
  options.focal_px = 320.0;
  options.gps_sigma_m = 1.0;
  const StreetScene scene(options);
  std::vector<Rigid3d> poses;
  const Eigen::Vector3d along(std::cos(options.heading_rad), std::sin(options.heading_rad), 0.0);
  const Eigen::Vector3d across(-along.y(), along.x(), 0.0);
  for (int i = 0; i < 10; ++i) {
    poses.push_back(StreetWorld::LookAlong(
        (1.5 * i - 7.0) * along - 2.0 * across + Eigen::Vector3d(0.0, 0.0, 1.6),
        options.heading_rad + 0.5 * kPi - 0.1));
  }
  fs::create_directories(dir / "photos");
  std::string positions = "image,lat_deg,lon_deg,h_m,accuracy_m\n";
  for (const StreetPhoto& photo : scene.TakePhotos(poses, "walk_")) {
    const std::vector<uint8_t> png = EncodePng(photo.image);
    Write(dir / "photos" / photo.name, png.data(), png.size());
    positions += fmt::format("{},{:.9f},{:.9f},{:.3f},2\n", photo.name, photo.gps->lat_deg(),
                             photo.gps->lon_deg(), photo.gps->h_m);
  }
  WriteText(dir / "positions.csv", positions);
}

StreetWorld MakeStreet() {
  StreetWorldOptions options;
  options.length_m = 45.0;
  options.num_landmarks = 800;
  return StreetWorld(options);
}

void WriteFrames(const fs::path& dir, const std::string& poses_path) {
  const StreetWorld street = MakeStreet();
  std::ifstream poses(poses_path);
  Eigen::Matrix<double, 3, 4> pose;
  for (int i = 0;; ++i) {
    for (int k = 0; k < 12; ++k) {
      poses >> pose(k / 4, k % 4);
    }
    if (!poses) {
      return;
    }
    std::vector<int> landmarks;
    const Eigen::Matrix3d rotation = pose.leftCols<3>();
    const FeatureSet features =
        street.Photograph(Rigid3d(rotation, pose.col(3)), 1000 + i, &landmarks);
    const std::string name = std::to_string(i);
    Write(dir / (name + ".keypoints.f32"), features.keypoints.data(),
          features.keypoints.size() * sizeof(Keypoint));
    Write(dir / (name + ".descriptors.f32"), features.descriptors.data(),
          static_cast<size_t>(features.descriptors.size()) * sizeof(float));
    Write(dir / (name + ".landmarks.i32"), landmarks.data(), landmarks.size() * sizeof(int));
  }
}

void Run(const fs::path& dir, bool with_photos) {
  const StreetWorld street = MakeStreet();
  const Reconstruction reconstruction = street.Reconstruct();
  fs::create_directories(dir / "colmap");
  WriteColmapModel(reconstruction, (dir / "colmap").string(), ColmapModelFormat::kBinary);
  WriteColmapDatabase(reconstruction, (dir / "colmap" / "database.db").string(), {});
  std::vector<EvalQuery> queries = MakeQueries(street);
  WriteFirst(queries.front(), dir);
  WriteQueryListWithFeatures((dir / "queries.json").string(), &queries);
  if (with_photos) {
    WritePhotos(dir);
  }
}

}  // namespace
}  // namespace cairn::testing

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: make_street DIR [--photos | --frames POSES]\n");
    return 2;
  }
  try {
    if (argc == 4 && std::string(argv[2]) == "--frames") {
      cairn::testing::WriteFrames(argv[1], argv[3]);
    } else {
      cairn::testing::Run(argv[1], argc > 2 && std::string(argv[2]) == "--photos");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_street: %s\n", error.what());
    return 1;
  }
  return 0;
}
