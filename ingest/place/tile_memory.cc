#include "ingest/place/tile_memory.h"

#include <fmt/format.h>

#include <cstddef>
#include <optional>
#include <utility>

#include "core/error.h"
#include "engine/localizer_options.h"
#include "storage/tile/content_digest.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// Some kilometers of streets.
constexpr size_t kDecodedBytes = size_t{256} << 20, kSearchableBytes = size_t{512} << 20;

}  // namespace

TileMemory::TileMemory()
    : decoded_(kDecodedBytes),
      searchable_(
          std::make_shared<TileCache>(kSearchableBytes, LocalizerOptions().matching.index)) {}

std::shared_ptr<const DecodedTile> TileMemory::Decoded(
    const std::string& digest, const std::function<LargeVector<uint8_t>()>& load) {
  return Made(digest, [&] {
    ++num_decoded_;
    return DecodePayload(load());
  });
}

std::shared_ptr<const DecodedTile> TileMemory::Made(const std::string& digest,
                                                    const std::function<DecodedTile()>& make) {
  return decoded_.GetOrLoad(digest, [&] { return std::make_shared<const DecodedTile>(make()); });
}

void TileMemory::Keep(std::span<const uint8_t> payload,
                      std::shared_ptr<const DecodedTile> decoded) {
  decoded_.GetOrLoad(ContentDigest(payload), [&] { return std::move(decoded); });
}

std::shared_ptr<const DecodedTile> RememberedTiles::Decoded(const TileRecord& record) const {
  const auto decoded =
      memory_->Decoded(record.digest, [&] { return map_.LoadPayload(record.payload_id); });
  if (decoded->tile.id != record.tile_id) {  // A damaged map may name the payload of another tile.
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("tile {}, payload {}: holds tile {}; run `cairn check` to find all "
                            "damage",
                            record.tile_id.ToString(), Value(record.payload_id),
                            decoded->tile.id.ToString()));
  }
  return decoded;
}

std::shared_ptr<const Tile> RememberedTiles::Find(TileId tile_id) const {
  const std::optional<TileRecord> record = map_.FindTile(tile_id);
  if (!record) {
    return nullptr;
  }
  const std::shared_ptr<const DecodedTile> decoded = Decoded(*record);
  return {decoded, &decoded->tile};
}

StoredTile RememberedTiles::LoadTile(const TileRecord& record) const {
  StoredTile stored;
  stored.decoded = Decoded(record);
  stored.accuracy = AccuracyOf(SessionsInTile(stored.decoded->tile), map_);
  return stored;
}

}  // namespace cairn
