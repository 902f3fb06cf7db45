// A decoded tile: the unit of the map that is stored, cached and searched.
#ifndef CAIRN_STORAGE_TILE_TILE_H_
#define CAIRN_STORAGE_TILE_TILE_H_

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/rigid3.h"
#include "core/tile_id.h"
#include "storage/ids.h"

namespace cairn {

// A mapping camera that stood in the tile.
struct TileKeyframe {
  KeyframeId id{};
  SessionId session_id{};
  Rigid3d cam_from_tile;
};

// What the keyframes standing in one tile saw. Structure of arrays; the descriptors of a landmark
// are contiguous. Landmarks should be in Morton order (see MortonOrder), which is what makes the
// encoded tile small; any order is kept.
//
// Positions are exact multiples of kPositionStepM and the per-descriptor bytes are stored as they
// are, so decode(encode(tile)) == tile and a tile can be rewritten without loss.
struct Tile {
  static constexpr double kPositionStepM = 1.0 / 256.0;  // 3.9 mm; error at most 2 mm an axis.

  TileId id;
  CodebookId codebook_id{};
  int code_size = 0;  // Bytes of a descriptor code.

  // Per landmark.
  std::vector<LandmarkId> landmark_ids;      // The same landmark keeps its id in every tile.
  std::vector<SessionId> landmark_sessions;  // The session that made it.
  std::vector<Eigen::Vector3f> x_in_tile;    // Metres.
  std::vector<uint8_t> sigma_codes;          // Position uncertainty, see SigmaFromCode.
  std::vector<uint32_t> descriptor_begin;    // num_landmarks + 1 offsets into the next arrays.

  // Per descriptor.
  std::vector<uint8_t> codes;              // num_descriptors x code_size, row-major.
  std::vector<uint8_t> orientation_codes;  // Gravity-rectified, see OrientationFromCode.
  std::vector<uint8_t> size_codes;         // Physical keypoint size, see SizeFromCode.
  std::vector<uint8_t> azimuth_codes;      // Direction from landmark to camera, as orientation.

  // Covisibility.
  std::vector<TileKeyframe> keyframes;
  std::vector<uint32_t> keyframe_begin;      // num_keyframes + 1 offsets into the next array.
  std::vector<uint32_t> keyframe_landmarks;  // Landmark indices, ascending within a keyframe.

  size_t num_landmarks() const { return x_in_tile.size(); }
  size_t num_descriptors() const { return orientation_codes.size(); }
  size_t num_keyframes() const { return keyframes.size(); }

  std::span<const uint32_t> LandmarksOfKeyframe(size_t keyframe_idx) const {
    return {keyframe_landmarks.data() + keyframe_begin[keyframe_idx],
            keyframe_begin[keyframe_idx + 1] - keyframe_begin[keyframe_idx]};
  }

  // Heap bytes in use.
  size_t MemoryBytes() const;

  // CAIRN_CHECKs nothing, throws Error(kInternal) if the arrays disagree; for use before encoding.
  void Validate() const;
};

// One-byte codes of a descriptor's and landmark's attributes.
// Angles and sizes must be numbers. Angle: 256 steps of a full turn; code 0 is angle 0.
// kNoOrientation marks "meaningless" (the viewing ray was vertical); the angle that would get this
// code is moved to its neighbour.
inline constexpr uint8_t kNoOrientation = 255;
uint8_t OrientationCode(double angle_rad);  // Never kNoOrientation.
double OrientationFromCode(uint8_t code);   // (-pi, pi]; must not be kNoOrientation.
uint8_t AzimuthCode(double azimuth_rad);    // All 256 codes; azimuth = atan2(north, east).
double AzimuthFromCode(uint8_t code);
// Physical size of a keypoint: scale_px / focal_px * distance, metres; 1 mm to 60 m in steps of
// 4.4 % (log scale), clamped.
uint8_t SizeCode(double size_m);
double SizeFromCode(uint8_t code);
// Standard deviation of a landmark position (root mean square over the axes), metres; 1 mm to 60 m
// on the same scale as the size, clamped.
uint8_t SigmaCode(double sigma_m);
double SigmaFromCode(uint8_t code);

// The nearest position a tile can hold; coordinates are clamped to [-4096 m, 4096 m). The position
// must be finite.
Eigen::Vector3f QuantizePosition(const Eigen::Vector3d& x_in_tile);

// Indices of quantised positions in the order of the Z-shaped curve through space; equal positions
// keep their order. Element i of the result is the position that comes i-th.
std::vector<uint32_t> MortonOrder(std::span<const Eigen::Vector3f> x_in_tile);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_H_
