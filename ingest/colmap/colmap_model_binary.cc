// COLMAP's binary model files: little-endian, no padding, every list preceded by a 64-bit count.
//
//   cameras.bin   count, { u32 camera_id, i32 model_id, u64 width, u64 height, f64 params[] }
//   images.bin    count, { u32 image_id, f64 qw qx qy qz tx ty tz, u32 camera_id, name, NUL,
//                          count, { f64 x, f64 y, i64 point3D_id } }
//   points3D.bin  count, { u64 point3D_id, f64 xyz[3], u8 rgb[3], f64 error,
//                          count, { u32 image_id, u32 point2D_idx } }
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/model_bytes.h"

namespace cairn {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied unchanged");

// Sizes of the fixed parts of the records above, in bytes. Counts are checked against them before
// use.
constexpr size_t kMinCameraBytes = 4 + 4 + 8 + 8 + 2 * 8;
constexpr size_t kMinImageBytes = 4 + 7 * 8 + 4 + 1 + 8;
constexpr size_t kKeypointBytes = 8 + 8 + 8;
constexpr size_t kMinPointBytes = 8 + 3 * 8 + 3 + 8 + 8;
constexpr size_t kTrackElementBytes = 4 + 4;

constexpr size_t kMaxNameBytes = size_t{1} << 16;
constexpr size_t kMaxReservedRecords = 10'000;

// Values of a model file, in order.
class ModelFile {
 public:
  ModelFile(const std::string& model_dir, const char* name)
      : path_(model_dir + "/" + name), bytes_(path_) {}

  [[noreturn]] void Throw(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: at byte {} of {}: {}", path_,
                                                  bytes_.position(), bytes_.size(), what));
  }

  template <typename T>
  T Get() {
    const std::string_view bytes = bytes_.Peek(sizeof(T));
    if (bytes.size() < sizeof(T)) {
      Throw("the file ends in the middle of a record");
    }
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    bytes_.Skip(sizeof(T));
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
    if (count > bytes_.remaining() / record_bytes) {
      Throw(fmt::format("{} {} do not fit into the rest of the file", count, what));
    }
    return count;
  }

  std::string GetName() {
    for (size_t num_bytes = 256;; num_bytes *= 2) {
      const std::string_view bytes = bytes_.Peek(num_bytes);
      if (const size_t end = bytes.find('\0'); end != std::string_view::npos) {
        std::string name(bytes.substr(0, end));
        bytes_.Skip(end + 1);
        return name;
      }
      if (bytes.size() < num_bytes || bytes.size() > kMaxNameBytes) {
        Throw("an image name does not end");
      }
    }
  }

  bool Has(size_t num_bytes) const { return bytes_.remaining() >= num_bytes; }

  void ExpectEnd() const {
    if (bytes_.remaining() > 0) {
      Throw("the file goes on after the last record");
    }
  }

 private:
  std::string path_;
  ModelBytes bytes_;
};

// Appends `count` records that `read` reads. The memory grows with what has been read, since a file
// may be sparse and its count a lie.
template <typename Record, typename Read>
void ReadRecords(size_t count, std::vector<Record>* records, const Read& read) {
  records->reserve(std::min(count, kMaxReservedRecords));
  for (size_t i = 0; i < count; ++i) {
    records->push_back(read());
  }
}

std::vector<double> ReadParams(ModelFile* file, int num_params) {
  std::vector<double> params;
  ReadRecords(static_cast<size_t>(num_params), &params, [&] { return file->Get<double>(); });
  return params;
}

// Returns the number of parameters of a model that COLMAP has and Cairn does not support. Returns
// -1 for all others.
int NumParamsOfUnsupported(int colmap_id) {
  // SIMPLE_DIVISION, DIVISION, SIMPLE_FISHEYE, FISHEYE, EUCM and EQUIRECTANGULAR.
  constexpr int kFirstId = 12;
  constexpr std::array<int, 6> kNumParams = {4, 5, 3, 4, 6, 2};
  const int64_t idx = int64_t{colmap_id} - kFirstId;
  return idx >= 0 && idx < std::ssize(kNumParams) ? kNumParams[static_cast<size_t>(idx)] : -1;
}

// Notes a camera whose model is not supported, which matters only if an image has it. Throws if the
// end of its record is unknown.
void SkipUnsupportedCamera(uint32_t camera_id, int colmap_id, const std::string& why,
                           ModelFile* file, ColmapModel* model) {
  const int num_params = NumParamsOfUnsupported(colmap_id);
  if (num_params < 0 || !file->Has(static_cast<size_t>(num_params) * sizeof(double))) {
    file->Throw(fmt::format("camera {}: {}", camera_id, why));
  }
  ReadParams(file, num_params);
  model->unsupported_cameras.insert_or_assign(camera_id, why);
}

void ReadCamera(ModelFile* file, ColmapModel* model) {
  const auto camera_id = file->Get<uint32_t>();
  const auto model_id = file->Get<int32_t>();
  const auto width = file->Get<uint64_t>();
  const auto height = file->Get<uint64_t>();
  CameraModel camera_model{};
  try {
    camera_model = CameraModelFromColmapId(model_id);
  } catch (const Error& e) {
    SkipUnsupportedCamera(camera_id, model_id, e.what(), file, model);
    return;
  }
  std::vector<double> params = ReadParams(file, NumCameraParams(camera_model));
  try {
    constexpr uint64_t kMax = std::numeric_limits<int>::max();
    model->cameras.insert_or_assign(
        camera_id, Camera(camera_model, static_cast<int>(std::min(width, kMax)),
                          static_cast<int>(std::min(height, kMax)), std::move(params)));
  } catch (const Error& e) {
    file->Throw(fmt::format("camera {}: {}", camera_id, e.what()));
  }
}

void ReadCameras(const std::string& model_dir, ColmapModel* model) {
  ModelFile file(model_dir, "cameras.bin");
  const size_t num_cameras = file.GetCount(kMinCameraBytes, "cameras");
  for (size_t i = 0; i < num_cameras; ++i) {
    ReadCamera(&file, model);
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

Eigen::Vector2f ReadPixel(ModelFile* file) {
  const double x_px = file->GetFinite("a keypoint");
  const double y_px = file->GetFinite("a keypoint");
  file->Get<int64_t>();  // Point id; points3D.bin has the same information.
  return Eigen::Vector2d(x_px, y_px).cast<float>();
}

ColmapImage ReadImage(ModelFile* file) {
  ColmapImage image;
  image.image_id = file->Get<uint32_t>();
  image.cam_from_world = ReadPose(file);
  image.camera_id = file->Get<uint32_t>();
  image.name = file->GetName();
  const size_t num_keypoints = file->GetCount(kKeypointBytes, "keypoints");
  if (num_keypoints > kMaxColmapKeypoints) {
    file->Throw(fmt::format("image {} has {} keypoints; at most {} are possible",
                            Excerpt(image.name), num_keypoints, kMaxColmapKeypoints));
  }
  ReadRecords(num_keypoints, &image.pixels, [&] { return ReadPixel(file); });
  return image;
}

void ReadImages(const std::string& model_dir, ColmapModel* model) {
  ModelFile file(model_dir, "images.bin");
  ReadRecords(file.GetCount(kMinImageBytes, "images"), &model->images,
              [&] { return ReadImage(&file); });
  file.ExpectEnd();
}

ColmapPoint ReadPoint(ModelFile* file) {
  ColmapPoint point;
  file->Get<uint64_t>();  // Point id.
  for (double& coordinate : point.x_in_world) {
    coordinate = file->GetFinite("a point");
  }
  for (int i = 0; i < 3; ++i) {
    file->Get<uint8_t>();  // Color.
  }
  file->Get<double>();  // Reprojection error.
  ReadRecords(file->GetCount(kTrackElementBytes, "observations"), &point.track, [&] {
    const auto image_id = file->Get<uint32_t>();
    return std::pair(image_id, file->Get<uint32_t>());
  });
  return point;
}

void ReadPoints(const std::string& model_dir, ColmapModel* model) {
  ModelFile file(model_dir, "points3D.bin");
  const size_t num_points = file.GetCount(kMinPointBytes, "points");
  for (size_t i = 0; i < num_points; ++i) {
    ColmapPoint point = ReadPoint(&file);
    if (!point.track.empty()) {  // A point that no image sees is of no use.
      model->points.push_back(std::move(point));
    }
  }
  file.ExpectEnd();
}

}  // namespace

uint64_t CountImagesOfBinaryModel(const std::string& model_dir) {
  return ModelFile(model_dir, "images.bin").GetCount(kMinImageBytes, "images");
}

ColmapModel ReadBinaryColmapModel(const std::string& model_dir) {
  ColmapModel model;
  ReadCameras(model_dir, &model);
  ReadImages(model_dir, &model);
  ReadPoints(model_dir, &model);
  return model;
}

}  // namespace cairn
