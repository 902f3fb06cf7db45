#include "ingest/maps/image_row.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "ingest/maps/require_input.h"
#include "ingest/maps/stored_values.h"
#include "storage/tile/camera_bytes.h"
#include "storage/tile/pose_bytes.h"

namespace cairn {
namespace {

constexpr uint32_t kMaxNameBytes = 4096;

// Plans store the quaternion w, x, y, z; other formats have w last.
void PutPoseOfPlan(const Rigid3d& pose, ByteWriter* writer) {
  const Eigen::Quaterniond& q = pose.rotation;
  writer->PutArray(std::span<const double>(std::array{q.w(), q.x(), q.y(), q.z()}));
  PutPoint(pose.translation, writer);
}

Rigid3d GetPoseOfPlan(ByteReader* reader) {
  std::array<double, 4> q;
  reader->GetArray(std::span<double>(q));
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  pose.translation = GetPoint(reader);
  RequireInput(pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1.0) < 1e-6,
               "the pose of an image is not rigid");
  return pose;
}

}  // namespace

void PutImageRow(const KeyframeRecord& keyframe, ByteWriter* writer) {
  RequireInput(keyframe.image_name.size() <= kMaxNameBytes,
               "the name of an image is longer than 4096 bytes");
  writer->Put(Value(keyframe.id));
  PutPoseOfPlan(keyframe.cam_from_ecef, writer);
  PutCamera(keyframe.camera, writer);
  stored::PutText(keyframe.image_name, writer);
}

KeyframeRecord GetImageRow(ByteReader* reader) {
  KeyframeRecord keyframe;
  keyframe.id = KeyframeId(reader->Get<int64_t>());
  keyframe.cam_from_ecef = GetPoseOfPlan(reader);
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
