// COLMAP's binary model files: little-endian, no padding, every list preceded by a 64-bit count.
//
//   cameras.bin   count, { u32 camera_id, i32 model_id, u64 width, u64 height, f64 params[] }
//   images.bin    count, { u32 image_id, f64 qw qx qy qz tx ty tz, u32 camera_id, name, NUL,
//                          count, { f64 x, f64 y, i64 point3D_id } }
//   points3D.bin  count, { u64 point3D_id, f64 xyz[3], u8 rgb[3], f64 error,
//                          count, { u32 image_id, u32 point2D_idx } }
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "core/error.h"
#include "core/file_bytes.h"
#include "ingest/readers/colmap_model.h"

namespace cairn {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied unchanged");

// Sizes of the fixed parts of the records above, in bytes. Counts are checked against them before
// use.
constexpr size_t kMinCameraBytes = 4 + 4 + 8 + 8 + 3 * 8;
constexpr size_t kMinImageBytes = 4 + 7 * 8 + 4 + 1 + 8;
constexpr size_t kKeypointBytes = 8 + 8 + 8;
constexpr size_t kMinPointBytes = 8 + 3 * 8 + 3 + 8 + 8;
constexpr size_t kTrackElementBytes = 4 + 4;

// Reads a file from front to back and tracks the position.
class ModelFile {
 public:
  ModelFile(const std::string& model_dir, const char* name)
      : path_(model_dir + "/" + name),
        bytes_(ReadFileBytes(path_, std::numeric_limits<uint64_t>::max())) {}

  [[noreturn]] void Throw(const std::string& what) const {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: at byte {} of {}: {}", path_, at_, bytes_.size(), what));
  }

  template <typename T>
  T Get() {
    if (bytes_.size() - at_ < sizeof(T)) {
      Throw("the file ends in the middle of a record");
    }
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  double GetFinite(const char* what) {
    const double value = Get<double>();
    if (!std::isfinite(value)) {
      Throw(fmt::format("{} is not finite", what));
    }
    return value;
  }

  // Reads a number of records that have at least `record_bytes` each.
  size_t GetCount(size_t record_bytes, const char* what) {
    const uint64_t count = Get<uint64_t>();
    if (count > (bytes_.size() - at_) / record_bytes) {
      Throw(fmt::format("{} {} do not fit into the rest of the file", count, what));
    }
    return count;
  }

  std::string GetName() {
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
    const auto end = std::find(begin, bytes_.end(), uint8_t{0});
    if (end == bytes_.end()) {
      Throw("the file ends in the middle of an image name");
    }
    at_ += static_cast<size_t>(end - begin) + 1;
    return std::string(begin, end);
  }

  void ExpectEnd() const {
    if (at_ != bytes_.size()) {
      Throw("the file goes on after the last record");
    }
  }

 private:
  std::string path_;
  std::vector<uint8_t> bytes_;
  size_t at_ = 0;
};

void ReadCameras(const std::string& model_dir, ColmapModel* model) {
  ModelFile file(model_dir, "cameras.bin");
  const size_t num_cameras = file.GetCount(kMinCameraBytes, "cameras");
  for (size_t i = 0; i < num_cameras; ++i) {
    const auto camera_id = file.Get<uint32_t>();
    const auto model_id = file.Get<int32_t>();
    const auto width = file.Get<uint64_t>();
    const auto height = file.Get<uint64_t>();
    try {
      const CameraModel camera_model = CameraModelFromColmapId(model_id);
      std::vector<double> params(NumCameraParams(camera_model));
      for (double& param : params) {
        param = file.Get<double>();
      }
      constexpr uint64_t kMax = std::numeric_limits<int>::max();
      model->cameras.insert_or_assign(
          camera_id, Camera(camera_model, static_cast<int>(std::min(width, kMax)),
                            static_cast<int>(std::min(height, kMax)), std::move(params)));
    } catch (const Error& e) {
      file.Throw(fmt::format("camera {}: {}", camera_id, e.what()));
    }
  }
  file.ExpectEnd();
}

Rigid3d ReadPose(ModelFile* file) {
  double values[7];
  for (double& value : values) {
    value = file->GetFinite("a pose");
  }
  const Eigen::Quaterniond rotation(values[0], values[1], values[2], values[3]);
  if (!(rotation.norm() > 1e-6)) {
    file->Throw("the rotation quaternion is zero");
  }
  return {rotation, Eigen::Vector3d(values[4], values[5], values[6])};
}

void ReadImages(const std::string& model_dir, ColmapModel* model) {
  ModelFile file(model_dir, "images.bin");
  model->images.resize(file.GetCount(kMinImageBytes, "images"));
  for (ColmapImage& image : model->images) {
    image.image_id = file.Get<uint32_t>();
    image.cam_from_world = ReadPose(&file);
    image.camera_id = file.Get<uint32_t>();
    image.name = file.GetName();
    image.pixels.resize(file.GetCount(kKeypointBytes, "keypoints"));
    for (Eigen::Vector2f& pixel : image.pixels) {
      const double x_px = file.GetFinite("a keypoint");
      const double y_px = file.GetFinite("a keypoint");
      pixel = Eigen::Vector2d(x_px, y_px).cast<float>();
      file.Get<int64_t>();  // Point id; points3D.bin has the same information.
    }
  }
  file.ExpectEnd();
}

void ReadPoints(const std::string& model_dir, ColmapModel* model) {
  ModelFile file(model_dir, "points3D.bin");
  model->points.resize(file.GetCount(kMinPointBytes, "points"));
  for (ColmapPoint& point : model->points) {
    file.Get<uint64_t>();  // Point id.
    for (double& coordinate : point.x_in_world) {
      coordinate = file.GetFinite("a point");
    }
    for (int i = 0; i < 3; ++i) {
      file.Get<uint8_t>();  // Color.
    }
    file.Get<double>();  // Reprojection error.
    point.track.resize(file.GetCount(kTrackElementBytes, "observations"));
    for (auto& [image_id, keypoint_idx] : point.track) {
      image_id = file.Get<uint32_t>();
      keypoint_idx = file.Get<uint32_t>();
    }
  }
  file.ExpectEnd();
}

}  // namespace

ColmapModel ReadBinaryColmapModel(const std::string& model_dir) {
  ColmapModel model;
  ReadCameras(model_dir, &model);
  ReadImages(model_dir, &model);
  ReadPoints(model_dir, &model);
  return model;
}

}  // namespace cairn
