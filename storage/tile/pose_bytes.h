// Points, rotations and poses as bytes. Private to storage, ingest and mapping.
#ifndef CAIRN_STORAGE_TILE_POSE_BYTES_H_
#define CAIRN_STORAGE_TILE_POSE_BYTES_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <span>

#include "core/rigid3.h"
#include "storage/tile/byte_io.h"

namespace cairn {

// Three doubles.
inline void PutPoint(const Eigen::Vector3d& point, ByteWriter* writer) {
  writer->PutArray(std::span<const double>(point.data(), 3));
}

inline Eigen::Vector3d GetPoint(ByteReader* reader) {
  Eigen::Vector3d point;
  reader->GetArray(std::span<double>(point.data(), 3));
  return point;
}

// Four doubles: the quaternion x, y, z, w.
inline void PutRotation(const Eigen::Quaterniond& rotation, ByteWriter* writer) {
  writer->PutArray(std::span<const double>(rotation.coeffs().data(), 4));
}

inline Eigen::Quaterniond GetRotation(ByteReader* reader) {
  Eigen::Quaterniond rotation;
  reader->GetArray(std::span<double>(rotation.coeffs().data(), 4));
  return rotation;
}

inline constexpr size_t kPoseBytes = 7 * sizeof(double);

// The rotation, then the translation.
inline void PutPose(const Rigid3d& pose, ByteWriter* writer) {
  PutRotation(pose.rotation, writer);
  PutPoint(pose.translation, writer);
}

// Returns the pose bit by bit: the constructor of Rigid3d would normalize it. The numbers of
// untrusted bytes may be any.
inline Rigid3d GetPose(ByteReader* reader) {
  Rigid3d pose;
  pose.rotation = GetRotation(reader);
  pose.translation = GetPoint(reader);
  return pose;
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_POSE_BYTES_H_
