// A decoded tile. Tiles are the units in which the map is stored, cached and searched.
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

// The observations of a landmark by the keyframes of one session in the tile.
struct HistoryEntry {
  SessionId session_id{};        // 0 sums up the sessions that are older than the other entries.
  uint8_t num_observations = 0;  // Keyframes that saw it; 255 stands for 255 or more.
  uint8_t num_chances = 0;       // Keyframes that should have seen it, num_observations at least.

  bool operator==(const HistoryEntry&) const = default;
};

// The landmarks seen by the keyframes that stand in the tile. Structure of arrays; the descriptors
// of a landmark are contiguous. Sort landmarks in Morton order (see MortonOrder) to make the
// encoded tile small; any other order is kept.
//
// Positions are exact multiples of kPositionStepM and the per-descriptor bytes are stored as they
// are. Hence decode(encode(tile)) == tile, and a tile can be rewritten without loss.
struct Tile {
  static constexpr double kPositionStepM = 1.0 / 256.0;  // 3.9 mm; error at most 2 mm per axis.

  TileId id;
  CodebookId codebook_id{};
  int code_size = 0;  // Bytes of a descriptor code.

  // Per landmark.
  std::vector<LandmarkId> landmark_ids;    // A landmark has the same id in every tile.
  std::vector<Eigen::Vector3f> x_in_tile;  // Meters.
  std::vector<uint8_t> sigma_codes;        // Position uncertainty; see SigmaFromCode.
  // num_landmarks + 1 offsets into the per-descriptor arrays.
  std::vector<uint32_t> descriptor_begin;

  // The history of each landmark: sessions in the order of ingest, each at most once, at most
  // kMaxHistory. Sessions that had no chance to see it are not in it.
  static constexpr size_t kMaxHistory = 5;
  std::vector<uint32_t> history_begin;  // num_landmarks + 1 offsets into the next array.
  std::vector<HistoryEntry> history;

  // Per descriptor.
  std::vector<uint8_t> codes;              // num_descriptors x code_size, row-major.
  std::vector<uint8_t> orientation_codes;  // Gravity-rectified, see OrientationFromCode.
  std::vector<uint8_t> size_codes;         // Physical keypoint size, see SizeFromCode.
  std::vector<uint8_t> azimuth_codes;      // Direction from landmark to camera, as orientation.
  std::vector<uint8_t> weight_codes;       // Observations behind it, see WeightFromCode.

  // Covisibility.
  std::vector<TileKeyframe> keyframes;
  std::vector<uint32_t> keyframe_begin;      // num_keyframes + 1 offsets into keyframe_landmarks.
  std::vector<uint32_t> keyframe_landmarks;  // Landmark indices, ascending within a keyframe.

  size_t num_landmarks() const { return x_in_tile.size(); }
  size_t num_descriptors() const { return orientation_codes.size(); }
  size_t num_keyframes() const { return keyframes.size(); }

  std::span<const uint32_t> LandmarksOfKeyframe(size_t keyframe_idx) const {
    return {keyframe_landmarks.data() + keyframe_begin[keyframe_idx],
            keyframe_begin[keyframe_idx + 1] - keyframe_begin[keyframe_idx]};
  }

  std::span<const HistoryEntry> HistoryOf(size_t landmark_idx) const {
    return {history.data() + history_begin[landmark_idx],
            history_begin[landmark_idx + 1] - history_begin[landmark_idx]};
  }

  // Returns the heap bytes in use.
  size_t MemoryBytes() const;

  // Call before encoding. Throws Error(kInternal) if the arrays are inconsistent.
  void Validate() const;
};

// One-byte codes of the attributes of descriptors and landmarks. Angles must be finite and sizes
// must be numbers. A full turn has 256 angle codes; code 0 is angle 0. Writers use only the
// multiples of a step, which are as precise as matching needs and take fewer bits; readers take
// every code. In orientations, kNoOrientation marks a meaningless angle (the viewing ray was
// vertical).
inline constexpr uint8_t kNoOrientation = 255;
inline constexpr int kOrientationCodeStep = 4;  // 5.6 degrees.
inline constexpr int kAzimuthCodeStep = 8;      // 11.25 degrees.
inline constexpr int kSizeCodeStep = 4;         // 19 %.
uint8_t OrientationCode(double angle_rad);      // Never returns kNoOrientation.
double OrientationFromCode(uint8_t code);       // In (-pi, pi]; `code` must not be kNoOrientation.
uint8_t AzimuthCode(double azimuth_rad);        // azimuth = atan2(north, east).
double AzimuthFromCode(uint8_t code);
// The physical size of a keypoint is scale_px / focal_px * distance, meters. 256 codes cover 1 mm
// to 60 m at equal ratios of 4.4 %; sizes outside are clamped. Size 0 is unknown and has code 255.
uint8_t SizeCode(double size_m);
double SizeFromCode(uint8_t code);
// Standard deviation of a landmark position (root mean square over the axes), meters. The scale is
// that of SizeCode, and every code is used: each merge shrinks a deviation by a few per cent.
uint8_t SigmaCode(double sigma_m);
double SigmaFromCode(uint8_t code);

// Number of observations behind a descriptor, in quarters from 1/4 to 63.75, clamped. Observations
// of old sessions count less than one each.
uint8_t WeightCode(double num_observations);
double WeightFromCode(uint8_t code);

// The nearest position a tile can hold; coordinates are clamped to [-4096 m, 4096 m). The position
// must be finite.
Eigen::Vector3f QuantizePosition(const Eigen::Vector3d& x_in_tile);

// Returns the indices of quantized positions in Morton (Z-curve) order: element i is the index of
// the i-th position on the curve. Equal positions keep their order.
std::vector<uint32_t> MortonOrder(std::span<const Eigen::Vector3f> x_in_tile);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_H_
