#include "ingest/colmap/colmap_model_writer.h"

#include <fmt/format.h>

#include <string_view>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

template <typename Value>
void PutValue(Value value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string PathIn(const std::string& dir, const char* stem, ColmapModelFormat format) {
  return fmt::format("{}/{}.{}", dir, stem, format == ColmapModelFormat::kBinary ? "bin" : "txt");
}

std::array<double, 7> PoseNumbers(const Rigid3d& cam_from_world) {
  const Eigen::Quaterniond& q = cam_from_world.rotation;
  const Eigen::Vector3d& t = cam_from_world.translation;
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

// The records of the files, in both formats.

std::string BinaryCamera(uint32_t id, const Camera& camera) {
  std::string bytes;
  PutValue(id, &bytes);
  PutValue(static_cast<int32_t>(camera.model()), &bytes);
  PutValue(static_cast<uint64_t>(camera.width_px()), &bytes);
  PutValue(static_cast<uint64_t>(camera.height_px()), &bytes);
  for (const double param : camera.params()) {
    PutValue(param, &bytes);
  }
  return bytes;
}

std::string TextCamera(uint32_t id, const Camera& camera) {
  return fmt::format("{} {} {} {} {}\n", id, CameraModelName(camera.model()), camera.width_px(),
                     camera.height_px(), fmt::join(camera.params(), " "));
}

std::string BinaryImage(uint32_t id, const std::string& name, uint32_t camera_id,
                        const Rigid3d& cam_from_world, std::span<const ColmapKeypoint> keypoints) {
  std::string bytes;
  PutValue(id, &bytes);
  for (const double value : PoseNumbers(cam_from_world)) {
    PutValue(value, &bytes);
  }
  PutValue(camera_id, &bytes);
  bytes.append(name.c_str(), name.size() + 1);
  PutValue(static_cast<uint64_t>(keypoints.size()), &bytes);
  for (const ColmapKeypoint& keypoint : keypoints) {
    PutValue(keypoint.x_px, &bytes);
    PutValue(keypoint.y_px, &bytes);
    PutValue(keypoint.point_id, &bytes);
  }
  return bytes;
}

std::string TextImage(uint32_t id, const std::string& name, uint32_t camera_id,
                      const Rigid3d& cam_from_world, std::span<const ColmapKeypoint> keypoints) {
  std::string text = fmt::format("{} {} {} {}\n", id, fmt::join(PoseNumbers(cam_from_world), " "),
                                 camera_id, name);
  for (const ColmapKeypoint& keypoint : keypoints) {
    text += fmt::format("{} {} {} ", keypoint.x_px, keypoint.y_px, keypoint.point_id);
  }
  return text + "\n";
}

std::string BinaryPoint(uint64_t id, const Eigen::Vector3d& x_in_world,
                        const std::array<uint8_t, 3>& rgb, double error_px,
                        std::span<const ColmapTrackElement> track) {
  std::string bytes;
  PutValue(id, &bytes);
  for (const double value : x_in_world) {
    PutValue(value, &bytes);
  }
  for (const uint8_t channel : rgb) {
    PutValue(channel, &bytes);
  }
  PutValue(error_px, &bytes);
  PutValue(static_cast<uint64_t>(track.size()), &bytes);
  for (const ColmapTrackElement& element : track) {
    PutValue(element.image_id, &bytes);
    PutValue(element.keypoint_idx, &bytes);
  }
  return bytes;
}

std::string TextPoint(uint64_t id, const Eigen::Vector3d& x_in_world,
                      const std::array<uint8_t, 3>& rgb, double error_px,
                      std::span<const ColmapTrackElement> track) {
  std::string text = fmt::format("{} {} {} {} {} {} {} {}", id, x_in_world.x(), x_in_world.y(),
                                 x_in_world.z(), rgb[0], rgb[1], rgb[2], error_px);
  for (const ColmapTrackElement& element : track) {
    text += fmt::format(" {} {}", element.image_id, element.keypoint_idx);
  }
  return text + "\n";
}

}  // namespace

ColmapModelWriter::ColmapModelWriter(const std::string& dir, ColmapModelFormat format)
    : format_(format),
      cameras_{FileReplacement(PathIn(dir, "cameras", format))},
      images_{FileReplacement(PathIn(dir, "images", format))},
      points_{FileReplacement(PathIn(dir, "points3D", format))} {
  if (is_binary()) {
    for (File* file : {&cameras_, &images_, &points_}) {
      std::string count;
      PutValue(uint64_t{0}, &count);  // Until Commit.
      file->file.Write(count);
    }
    return;
  }
  cameras_.file.Write("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n");
  images_.file.Write(
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
      "# POINTS2D[] as (X, Y, POINT3D_ID)\n");
  points_.file.Write("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n");
}

void ColmapModelWriter::AddCamera(uint32_t id, const Camera& camera) {
  cameras_.file.Write(is_binary() ? BinaryCamera(id, camera) : TextCamera(id, camera));
  ++cameras_.num_records;
}

void ColmapModelWriter::AddImage(uint32_t id, const std::string& name, uint32_t camera_id,
                                 const Rigid3d& cam_from_world,
                                 std::span<const ColmapKeypoint> keypoints) {
  if (name.find_first_of(std::string_view("\0\r\n", 3)) != std::string::npos) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("COLMAP models cannot hold the image name {}", Excerpt(name)));
  }
  images_.file.Write(is_binary() ? BinaryImage(id, name, camera_id, cam_from_world, keypoints)
                                 : TextImage(id, name, camera_id, cam_from_world, keypoints));
  ++images_.num_records;
}

void ColmapModelWriter::AddPoint(uint64_t id, const Eigen::Vector3d& x_in_world,
                                 const std::array<uint8_t, 3>& rgb, double error_px,
                                 std::span<const ColmapTrackElement> track) {
  points_.file.Write(is_binary() ? BinaryPoint(id, x_in_world, rgb, error_px, track)
                                 : TextPoint(id, x_in_world, rgb, error_px, track));
  ++points_.num_records;
}

void ColmapModelWriter::Commit() {
  for (File* file : {&cameras_, &images_, &points_}) {
    if (is_binary()) {
      std::string count;
      PutValue(file->num_records, &count);
      file->file.Overwrite(0, count);
    }
    file->file.Commit();
  }
}

}  // namespace cairn
