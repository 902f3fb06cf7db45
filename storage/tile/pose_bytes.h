// A pose as bytes.
#ifndef CAIRN_STORAGE_TILE_POSE_BYTES_H_
#define CAIRN_STORAGE_TILE_POSE_BYTES_H_

#include <array>
#include <span>

#include "core/rigid3.h"
#include "storage/tile/byte_io.h"

namespace cairn {

// Seven doubles: the quaternion w, x, y, z, and the translation. Other formats have their own
// order.
inline void PutPose(const Rigid3d& pose, ByteWriter* writer) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  writer->PutArray(
      std::span<const double>(std::array{q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}));
}

// Returns the pose bit by bit: the constructor of Rigid3d would normalize it. The numbers of
// untrusted bytes may be any.
inline Rigid3d GetPose(ByteReader* reader) {
  std::array<double, 7> numbers;
  reader->GetArray(std::span<double>(numbers));
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(numbers[0], numbers[1], numbers[2], numbers[3]);
  pose.translation = {numbers[4], numbers[5], numbers[6]};
  return pose;
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_POSE_BYTES_H_
