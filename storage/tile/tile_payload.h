// An encoded tile whose parts are decoded on demand.
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

// A tile's landmarks. `view` points into `memory`.
struct LoadedLandmarks {
  LargeVector<uint8_t> memory;
  TileLandmarks view;
};

// The arrays behind a TileCovisibility.
struct LoadedCovisibility {
  std::vector<TileKeyframe> keyframes;
  LargeVector<uint32_t> keyframe_begin;
  LargeVector<uint32_t> keyframe_landmarks;
};

// A payload with lists, from which the parts needed for search can be read separately. Immutable;
// safe to use from any thread.
class TilePayload {
 public:
  // Returns true if the bytes are marked as a tile payload with lists.
  static bool IsSearchReady(std::span<const uint8_t> bytes);

  // Checks header, sizes and checksum. Throws Error(kMapDamaged), also if the payload has no lists.
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
  // Heap bytes of the results of Landmarks and Covisibility.
  size_t LandmarkBytes() const;
  size_t CovisibilityBytes() const;

  // num_descriptors() x code_size(), in list order; valid as long as the payload.
  std::span<const uint8_t> codes() const;
  // Throws Error(kMapDamaged).
  TileLists Lists() const;
  // Returns the codes in tile order. `members` are the members of the tile's lists.
  LargeVector<uint8_t> CodesInTileOrder(std::span<const uint32_t> members) const;
  // Landmarks and Covisibility throw Error(kMapDamaged).
  LoadedLandmarks Landmarks() const;
  LoadedCovisibility Covisibility() const;

 private:
  LargeVector<uint8_t> bytes_;
  std::unique_ptr<const TileColumns> columns_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_PAYLOAD_H_
