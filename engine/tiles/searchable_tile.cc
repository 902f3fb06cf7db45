#include "engine/tiles/searchable_tile.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

void RequireCodebook(TileId id, CodebookId codebook_id, int code_size, const Codebook& codebook) {
  if (codebook_id != codebook.id || code_size != codebook.num_subspaces) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("tile {} has {}-byte codes of codebook {}, but codebook {} has {}-byte "
                            "codes; run `cairn check` for details",
                            id.ToString(), code_size, Value(codebook_id), Value(codebook.id),
                            codebook.num_subspaces));
  }
}

std::unique_ptr<const MatchingIndex> IndexOf(const Tile& tile, const Codebook& codebook,
                                             const IndexOptions& options, TileLists lists,
                                             BuildExtent extent) {
  RequireCodebook(tile.id, tile.codebook_id, tile.code_size, codebook);
  return MakeMatchingIndex(codebook, tile.codes, options, std::move(lists), extent);
}

std::unique_ptr<const MatchingIndex> IndexOf(const TilePayload& payload, const Codebook& codebook,
                                             const IndexOptions& options) {
  RequireCodebook(payload.id(), payload.codebook_id(), payload.code_size(), codebook);
  return MakeIndexInListOrder(codebook, payload.codes(), options, payload.Lists());
}

std::unique_ptr<const MatchingIndex> IndexOf(const TilePayload& payload, const Codebook& codebook,
                                             const IndexOptions& options,
                                             std::span<const uint8_t> codes, BuildExtent extent) {
  RequireCodebook(payload.id(), payload.codebook_id(), payload.code_size(), codebook);
  return MakeMatchingIndex(codebook, codes, options, {}, extent);
}

}  // namespace

SearchableTile::SearchableTile(std::shared_ptr<const Tile> tile,
                               std::shared_ptr<const Codebook> codebook,
                               const IndexOptions& options, TileLists lists, BuildExtent extent)
    : id_(tile->id),
      num_descriptors_(tile->num_descriptors()),
      codebook_(std::move(codebook)),
      ecef_from_tile_(EcefFromEnu(id_.Anchor())),
      index_(IndexOf(*tile, *codebook_, options, std::move(lists), extent)),
      content_(std::move(tile), index_->order()) {
  if (options.num_reference_words > 0) {
    constexpr int kNumIterations = 5;
    constexpr uint64_t kSeed = 1;
    reference_words_.emplace(ByteDescriptors(*codebook_, codes()), options.num_reference_words,
                             kNumIterations, kSeed);
  }
}

bool SearchableTile::NeedsCodesAsStored(const IndexOptions& options) {
  return IsBuiltInListOrder(options) && options.num_reference_words == 0;
}

SearchableTile::SearchableTile(TilePayload payload, std::shared_ptr<const Codebook> codebook,
                               const IndexOptions& options)
    : SearchableTile(std::move(payload), codebook, IndexOf(payload, *codebook, options)) {}

SearchableTile::SearchableTile(TilePayload&& payload, std::shared_ptr<const Codebook> codebook,
                               std::unique_ptr<const MatchingIndex> index)
    : id_(payload.id()),
      num_descriptors_(payload.num_descriptors()),
      codebook_(std::move(codebook)),
      ecef_from_tile_(EcefFromEnu(id_.Anchor())),
      index_(std::move(index)),
      content_(std::move(payload), index_->order()) {}

SearchableTile::SearchableTile(TilePayload payload, std::shared_ptr<const Codebook> codebook,
                               const IndexOptions& options, LargeVector<uint8_t> codes,
                               BuildExtent extent)
    : id_(payload.id()),
      num_descriptors_(payload.num_descriptors()),
      codebook_(std::move(codebook)),
      ecef_from_tile_(EcefFromEnu(id_.Anchor())),
      index_(IndexOf(payload, *codebook_, options, codes, extent)),
      content_(std::move(payload), index_->order(), std::move(codes)) {}

std::vector<double> SearchableTile::ReferenceDistances(const DescriptorMatrix& queries) const {
  return reference_words_ ? reference_words_->NearestDistances(ByteScale(*codebook_), queries)
                          : std::vector<double>(queries.rows(), 0.0);
}

size_t SearchableTile::MemoryBytes() const {
  return sizeof(*this) + content_.MemoryBytes() + index_->MemoryBytes() +
         (reference_words_ ? reference_words_->MemoryBytes() : 0);
}

namespace {

std::shared_ptr<SearchableTile> MakeFromPayload(LargeVector<uint8_t> payload,
                                                std::shared_ptr<const Codebook> codebook,
                                                const IndexOptions& options) {
  if (options.num_reference_words == 0 && TilePayload::IsSearchReady(payload)) {
    TilePayload parts(std::move(payload));
    if (SearchableTile::NeedsCodesAsStored(options)) {
      return std::make_shared<SearchableTile>(std::move(parts), std::move(codebook), options);
    }
    LargeVector<uint8_t> codes = parts.CodesInTileOrder(parts.Lists().members);
    return std::make_shared<SearchableTile>(std::move(parts), std::move(codebook), options,
                                            std::move(codes), BuildExtent::kFirstPart);
  }
  DecodedTile decoded = DecodePayload(payload);
  return std::make_shared<SearchableTile>(std::make_shared<const Tile>(std::move(decoded.tile)),
                                          std::move(codebook), options, std::move(decoded.lists),
                                          BuildExtent::kFirstPart);
}

}  // namespace

std::shared_ptr<const SearchableTile> MakeSearchableTile(
    LargeVector<uint8_t> payload, std::shared_ptr<const Codebook> codebook,
    const IndexOptions& options, const std::optional<SessionAccuracy>& accuracy) {
  const auto tile = MakeFromPayload(std::move(payload), std::move(codebook), options);
  tile->set_accuracy(accuracy);
  return tile;
}

std::shared_ptr<const SearchableTile> MakeSearchableTile(
    const std::shared_ptr<const DecodedTile>& decoded, std::shared_ptr<const Codebook> codebook,
    const IndexOptions& options, const std::optional<SessionAccuracy>& accuracy) {
  const auto tile = std::make_shared<SearchableTile>(
      std::shared_ptr<const Tile>(decoded, &decoded->tile), std::move(codebook), options,
      decoded->lists, BuildExtent::kFirstPart);
  tile->set_accuracy(accuracy);
  return tile;
}

}  // namespace cairn
