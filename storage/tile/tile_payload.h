// A tile as it is stored, whose parts are decoded when they are wanted.
#ifndef CAIRN_STORAGE_TILE_TILE_PAYLOAD_H_
#define CAIRN_STORAGE_TILE_TILE_PAYLOAD_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/large_vector.h"
#include "core/tile_id.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_codec.h"
#include "storage/tile/tile_lists.h"
#include "storage/tile/tile_views.h"

namespace cairn {

class TileColumns;

// A tile's landmarks in one block of memory, of which the view tells.
struct LoadedLandmarks {
  LargeVector<uint8_t> memory;
  TileLandmarks view;
};

// The arrays of TileCovisibility.
struct LoadedCovisibility {
  std::vector<TileKeyframe> keyframes;
  LargeVector<uint32_t> keyframe_begin;
  LargeVector<uint32_t> keyframe_landmarks;
};

// A payload that has lists: what search needs stands by itself in it. Immutable; safe
// to use from any thread.
class TilePayload {
 public:
  // True if the bytes say that they are such a payload.
  static bool IsSearchReady(std::span<const uint8_t> bytes);

  // Checks header, sizes and checksum. Throws Error(kMapDamaged), also if they are no such payload.
  explicit TilePayload(LargeVector<uint8_t> bytes, const TileDecodeLimits& limits = {});
  TilePayload(TilePayload&&) noexcept;
  ~TilePayload();

  TileId id() const;
  CodebookId codebook_id() const;
  int code_size() const;
  size_t num_landmarks() const;
  size_t num_descriptors() const;
  size_t num_observations() const;
  size_t num_bytes() const { return bytes_.size(); }
  // Heap bytes of what Landmarks and Covisibility return.
  size_t LandmarkBytes() const;
  size_t CovisibilityBytes() const;

  // num_descriptors() x code_size(), in the order of the lists; valid as long as the payload.
  std::span<const uint8_t> codes() const;
  // Throws Error(kMapDamaged).
  TileLists Lists() const;
  // The same codes in the order of the tile; `members` are those of its lists.
  LargeVector<uint8_t> CodesInTileOrder(std::span<const uint32_t> members) const;
  // Both throw Error(kMapDamaged).
  LoadedLandmarks Landmarks() const;
  LoadedCovisibility Covisibility() const;

 private:
  LargeVector<uint8_t> bytes_;
  std::unique_ptr<const TileColumns> columns_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_PAYLOAD_H_
