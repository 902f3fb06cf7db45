#include "ingest/maps/image_row.h"

#include <cmath>
#include <string>
#include <utility>

#include "ingest/maps/require_input.h"

namespace cairn {
namespace {

constexpr uint32_t kMaxNameBytes = 4096;

void PutPose(const Rigid3d& pose, ByteWriter* writer) {
  for (const double value :
       {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z(),
        pose.translation.x(), pose.translation.y(), pose.translation.z()}) {
    writer->Put(value);
  }
}

Rigid3d GetPose(ByteReader* reader) {
  double values[7];
  reader->GetArray(std::span<double>(values));
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(values[0], values[1], values[2], values[3]);
  pose.translation = Eigen::Vector3d(values[4], values[5], values[6]);
  RequireInput(pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1.0) < 1e-6,
               "the pose of an image is not rigid");
  return pose;
}

void PutCamera(const Camera& camera, ByteWriter* writer) {
  writer->Put(static_cast<uint32_t>(camera.model()));
  writer->Put(static_cast<int32_t>(camera.width_px()));
  writer->Put(static_cast<int32_t>(camera.height_px()));
  writer->PutArray(std::span<const double>(camera.params()));
}

Camera GetCamera(ByteReader* reader) {
  const auto model_id = reader->Get<uint32_t>();
  RequireInput(model_id <= static_cast<uint32_t>(CameraModel::kRadTanThinPrismFisheye),
               "the camera of an image is of an unknown model");
  const auto model = static_cast<CameraModel>(model_id);
  const auto width_px = reader->Get<int32_t>();
  const auto height_px = reader->Get<int32_t>();
  return Camera(model, width_px, height_px,
                reader->GetVector<double>(static_cast<size_t>(NumCameraParams(model))));
}

}  // namespace

void PutImageRow(const KeyframeRecord& keyframe, ByteWriter* writer) {
  RequireInput(keyframe.image_name.size() <= kMaxNameBytes,
               "the name of an image is longer than 4096 bytes");
  writer->Put(Value(keyframe.id));
  PutPose(keyframe.cam_from_ecef, writer);
  PutCamera(keyframe.camera, writer);
  writer->Put(static_cast<uint32_t>(keyframe.image_name.size()));
  writer->PutArray(std::span<const char>(keyframe.image_name));
}

KeyframeRecord GetImageRow(ByteReader* reader) {
  KeyframeRecord keyframe;
  keyframe.id = KeyframeId(reader->Get<int64_t>());
  keyframe.cam_from_ecef = GetPose(reader);
  keyframe.camera = GetCamera(reader);
  const auto name_bytes = reader->Get<uint32_t>();
  RequireInput(keyframe.id >= KeyframeId(1) && name_bytes <= kMaxNameBytes,
               "the id or the name of an image is out of range");
  const std::span<const uint8_t> name = reader->Take(name_bytes);
  keyframe.image_name.assign(name.begin(), name.end());
  return keyframe;
}

std::vector<KeyframeRecord> GetImageRows(size_t count, ByteReader* reader) {
  RequireInput(count <= reader->remaining() / kMinImageRowBytes, "ends before its images");
  std::vector<KeyframeRecord> rows;
  rows.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    rows.push_back(GetImageRow(reader));
  }
  return rows;
}

}  // namespace cairn
