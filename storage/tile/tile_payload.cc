#include "storage/tile/tile_payload.h"

#include <utility>

#include "storage/tile/tile_columns.h"
#include "storage/tile/tile_decode.h"
#include "storage/tile/tile_parts.h"

namespace cairn {

bool TilePayload::IsSearchReady(std::span<const uint8_t> bytes) {
  return TileColumns::IsPayload(bytes) && TileColumns::HasLists(bytes);
}

TilePayload::TilePayload(LargeVector<uint8_t> bytes, const TileDecodeLimits& limits)
    : bytes_(std::move(bytes)), columns_(std::make_unique<const TileColumns>(bytes_, limits)) {
  if (columns_->header().num_lists == 0) {
    ThrowDamagedTile("has no lists");
  }
}

TilePayload::TilePayload(TilePayload&&) noexcept = default;
TilePayload::~TilePayload() = default;

TileId TilePayload::id() const { return TileIdFromPayload(columns_->header().tile_id); }
CodebookId TilePayload::codebook_id() const { return CodebookId(columns_->header().codebook_id); }
int TilePayload::code_size() const { return columns_->header().code_size; }
size_t TilePayload::num_landmarks() const { return columns_->header().num_landmarks; }
size_t TilePayload::num_descriptors() const { return columns_->header().num_descriptors; }
size_t TilePayload::num_observations() const { return columns_->header().num_observations; }
size_t TilePayload::LandmarkBytes() const { return columns_->header().LandmarksSize(); }
size_t TilePayload::CovisibilityBytes() const { return columns_->header().CovisibilitySize(); }
std::span<const uint8_t> TilePayload::codes() const { return columns_->codes(); }
TileLists TilePayload::Lists() const { return DecodeLists(*columns_); }

LoadedLandmarks TilePayload::Landmarks() const { return DecodeLandmarks(*columns_); }
LoadedCovisibility TilePayload::Covisibility() const { return DecodeCovisibility(*columns_); }

LargeVector<uint8_t> TilePayload::CodesInTileOrder(std::span<const uint32_t> members) const {
  return cairn::CodesInTileOrder(*columns_, members);
}

}  // namespace cairn
