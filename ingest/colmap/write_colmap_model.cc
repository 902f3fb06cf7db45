#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "ingest/colmap/colmap_ids.h"
#include "ingest/colmap/write_colmap.h"

namespace cairn {
namespace {

constexpr uint8_t kGray = 128;
constexpr double kErrorPx = 0.5;
constexpr int64_t kNoPoint = -1;

// An output file that throws if it cannot be written.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path) : path_(path), stream_(path, std::ios::binary) {
    stream_.precision(17);
  }

  std::ofstream& stream() { return stream_; }
  template <typename Value>
  void Put(Value value) {
    stream_.write(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  void Close() {
    stream_.close();
    if (!stream_) {
      throw Error(ErrorCode::kIo, path_ + ": cannot write");
    }
  }

 private:
  std::string path_;
  std::ofstream stream_;
};

// For each keypoint of each image, COLMAP's id of its point.
using PointIds = std::vector<std::vector<int64_t>>;

PointIds FindPointIds(const Reconstruction& reconstruction) {
  PointIds ids;
  for (const ReconImage& image : reconstruction.images) {
    ids.emplace_back(image.features.keypoints.size(), kNoPoint);
  }
  for (size_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    for (const ReconObservation& observation : reconstruction.landmarks[i].observations) {
      ids[static_cast<size_t>(observation.image_idx)]
         [static_cast<size_t>(observation.keypoint_idx)] =
             static_cast<int64_t>(kFirstColmapPointId + i);
    }
  }
  return ids;
}

void WriteBinaryCameras(const Reconstruction& reconstruction, const std::string& dir) {
  OutputFile file(dir + "/cameras.bin");
  file.Put(static_cast<uint64_t>(reconstruction.cameras.size()));
  for (size_t i = 0; i < reconstruction.cameras.size(); ++i) {
    const Camera& camera = reconstruction.cameras[i];
    file.Put(static_cast<uint32_t>(kFirstColmapCameraId + i));
    file.Put(static_cast<int32_t>(camera.model()));
    file.Put(static_cast<uint64_t>(camera.width_px()));
    file.Put(static_cast<uint64_t>(camera.height_px()));
    for (const double param : camera.params()) {
      file.Put(param);
    }
  }
  file.Close();
}

void WriteBinaryImages(const Reconstruction& reconstruction, const std::string& dir) {
  const PointIds point_ids = FindPointIds(reconstruction);
  OutputFile file(dir + "/images.bin");
  file.Put(static_cast<uint64_t>(reconstruction.images.size()));
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    const ReconImage& image = reconstruction.images[i];
    file.Put(static_cast<uint32_t>(kFirstColmapImageId + i));
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) {
      file.Put(value);
    }
    for (const double value : image.cam_from_world.translation) {
      file.Put(value);
    }
    file.Put(kFirstColmapCameraId + static_cast<uint32_t>(image.camera_idx));
    file.stream().write(image.name.c_str(), static_cast<std::streamsize>(image.name.size() + 1));
    file.Put(static_cast<uint64_t>(image.features.keypoints.size()));
    for (size_t k = 0; k < image.features.keypoints.size(); ++k) {
      file.Put(static_cast<double>(image.features.keypoints[k].x_px));
      file.Put(static_cast<double>(image.features.keypoints[k].y_px));
      file.Put(point_ids[i][k]);
    }
  }
  file.Close();
}

void WriteBinaryPoints(const Reconstruction& reconstruction, const std::string& dir) {
  OutputFile file(dir + "/points3D.bin");
  file.Put(static_cast<uint64_t>(reconstruction.landmarks.size()));
  for (size_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    const ReconLandmark& landmark = reconstruction.landmarks[i];
    file.Put(kFirstColmapPointId + i);
    for (const double value : landmark.x_in_world) {
      file.Put(value);
    }
    for (int channel = 0; channel < 3; ++channel) {
      file.Put(kGray);
    }
    file.Put(kErrorPx);
    file.Put(static_cast<uint64_t>(landmark.observations.size()));
    for (const ReconObservation& observation : landmark.observations) {
      file.Put(kFirstColmapImageId + static_cast<uint32_t>(observation.image_idx));
      file.Put(static_cast<uint32_t>(observation.keypoint_idx));
    }
  }
  file.Close();
}

void WriteTextCameras(const Reconstruction& reconstruction, const std::string& dir) {
  OutputFile file(dir + "/cameras.txt");
  file.stream() << "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (size_t i = 0; i < reconstruction.cameras.size(); ++i) {
    const Camera& camera = reconstruction.cameras[i];
    file.stream() << kFirstColmapCameraId + i << ' ' << CameraModelName(camera.model()) << ' '
                  << camera.width_px() << ' ' << camera.height_px();
    for (const double param : camera.params()) {
      file.stream() << ' ' << param;
    }
    file.stream() << '\n';
  }
  file.Close();
}

void WriteTextImages(const Reconstruction& reconstruction, const std::string& dir) {
  const PointIds point_ids = FindPointIds(reconstruction);
  OutputFile file(dir + "/images.txt");
  file.stream() << "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
                   "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    const ReconImage& image = reconstruction.images[i];
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    file.stream() << kFirstColmapImageId + i << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' '
                  << q.z() << ' ' << image.cam_from_world.translation.transpose() << ' '
                  << kFirstColmapCameraId + static_cast<uint32_t>(image.camera_idx) << ' '
                  << image.name << '\n';
    for (size_t k = 0; k < image.features.keypoints.size(); ++k) {
      const Keypoint& keypoint = image.features.keypoints[k];
      file.stream() << keypoint.x_px << ' ' << keypoint.y_px << ' ' << point_ids[i][k] << ' ';
    }
    file.stream() << '\n';
  }
  file.Close();
}

void WriteTextPoints(const Reconstruction& reconstruction, const std::string& dir) {
  OutputFile file(dir + "/points3D.txt");
  file.stream() << "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (size_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    const ReconLandmark& landmark = reconstruction.landmarks[i];
    file.stream() << kFirstColmapPointId + i << ' ' << landmark.x_in_world.transpose();
    for (int channel = 0; channel < 3; ++channel) {
      file.stream() << ' ' << int{kGray};
    }
    file.stream() << ' ' << kErrorPx;
    for (const ReconObservation& observation : landmark.observations) {
      file.stream() << ' ' << kFirstColmapImageId + static_cast<uint32_t>(observation.image_idx)
                    << ' ' << observation.keypoint_idx;
    }
    file.stream() << '\n';
  }
  file.Close();
}

}  // namespace

void WriteColmapModel(const Reconstruction& reconstruction, const std::string& dir,
                      ColmapModelFormat format) {
  if (format == ColmapModelFormat::kBinary) {
    WriteBinaryCameras(reconstruction, dir);
    WriteBinaryImages(reconstruction, dir);
    WriteBinaryPoints(reconstruction, dir);
  } else {
    WriteTextCameras(reconstruction, dir);
    WriteTextImages(reconstruction, dir);
    WriteTextPoints(reconstruction, dir);
  }
}

}  // namespace cairn
