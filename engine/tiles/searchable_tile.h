// A tile with its matching index, ready for search.
#ifndef CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_
#define CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/geodesy.h"
#include "core/large_vector.h"
#include "engine/index/matching_index.h"
#include "engine/index/product_words.h"
#include "engine/tiles/descriptor_places.h"
#include "engine/tiles/tile_content.h"
#include "storage/codebook/codebook.h"
#include "storage/map/session_accuracy.h"
#include "storage/tile/decoded_tile.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_lists.h"
#include "storage/tile/tile_payload.h"

namespace cairn {

// Queries share tiles through the cache. Safe to use from any thread.
class SearchableTile {
 public:
  // Builds the index or its first part. `tile` must be consistent (as DecodeTile returns it).
  // `lists` are the tile's lists, if any. Throws Error(kMapDamaged) if `codebook` is not the
  // tile's, and what MakeMatchingIndex throws.
  SearchableTile(Tile tile, std::shared_ptr<const Codebook> codebook, const IndexOptions& options,
                 TileLists lists = {}, BuildExtent extent = BuildExtent::kWhole)
      : SearchableTile(std::make_shared<const Tile>(std::move(tile)), std::move(codebook), options,
                       std::move(lists), extent) {}
  // Shares a tile that others use, too.
  SearchableTile(std::shared_ptr<const Tile> tile, std::shared_ptr<const Codebook> codebook,
                 const IndexOptions& options, TileLists lists, BuildExtent extent);

  // Returns true if the index for these options is built from a payload's codes and lists alone, as
  // they are stored.
  static bool NeedsCodesAsStored(const IndexOptions& options);
  // For such options: builds the index and decodes the rest of the payload when a query needs it.
  // Throws what the first constructor throws.
  SearchableTile(TilePayload payload, std::shared_ptr<const Codebook> codebook,
                 const IndexOptions& options);
  // For options without reference words: works like the constructor above, with an index of any
  // kind. `codes` are the payload's codes in tile order. Throws what the first constructor throws.
  SearchableTile(TilePayload payload, std::shared_ptr<const Codebook> codebook,
                 const IndexOptions& options, LargeVector<uint8_t> codes, BuildExtent extent);

  TileId id() const { return id_; }
  size_t num_descriptors() const { return num_descriptors_; }
  const Codebook& codebook() const { return *codebook_; }
  const MatchingIndex& index() const { return *index_; }
  // Returns the distance in projected space from each query (n x dim) to the nearest reference
  // word; 0 if the options ask for no reference words. Throws Error(kInternal) if the dimensions
  // differ.
  std::vector<double> ReferenceDistances(const DescriptorMatrix& queries) const;
  const Rigid3d& ecef_from_tile() const { return ecef_from_tile_; }

  // Decodes the half of the tile that matching needs, so that matching does not wait for it. Throws
  // what landmarks() throws.
  void Prepare() const { content_.places(); }

  // The accessors below may wait until their half of the tile is decoded: the half that matching
  // needs, or the rest. They throw Error(kMapDamaged) if it does not decode.
  const TileLandmarks& landmarks() const { return content_.landmarks(); }
  // In the order of the index.
  const DescriptorPlaces& places() const { return content_.places(); }
  const TileCovisibility& covisibility() const { return content_.covisibility(); }
  // num_descriptors() x codebook().num_subspaces, in tile order.
  std::span<const uint8_t> codes() const { return content_.codes(); }
  // Needs both halves.
  const LandmarkKeyframes& landmark_keyframes() const { return content_.landmark_keyframes(); }

  // The accuracy of the sessions in the tile; empty if the map does not know it. Set before the
  // tile is shared.
  const std::optional<SessionAccuracy>& accuracy() const { return accuracy_; }
  void set_accuracy(const std::optional<SessionAccuracy>& accuracy) { accuracy_ = accuracy; }

  size_t MemoryBytes() const;

 private:
  SearchableTile(TilePayload&& payload, std::shared_ptr<const Codebook> codebook,
                 std::unique_ptr<const MatchingIndex> index);

  TileId id_;
  size_t num_descriptors_;
  std::shared_ptr<const Codebook> codebook_;
  Rigid3d ecef_from_tile_;
  std::unique_ptr<const MatchingIndex> index_;
  std::optional<ProductWords> reference_words_;
  TileContent content_;
  std::optional<SessionAccuracy> accuracy_;
};

// Makes a payload from LoadPayload searchable in the fastest way, with at least the first part of
// its index. `accuracy` is that of the tile's sessions, if known. Throws Error(kMapDamaged) if the
// payload does not decode or belongs to another codebook.
std::shared_ptr<const SearchableTile> MakeSearchableTile(
    LargeVector<uint8_t> payload, std::shared_ptr<const Codebook> codebook,
    const IndexOptions& options, const std::optional<SessionAccuracy>& accuracy = {});
// Makes a decoded tile searchable, and shares its memory. Answers queries as its payload does.
std::shared_ptr<const SearchableTile> MakeSearchableTile(
    const std::shared_ptr<const DecodedTile>& decoded, std::shared_ptr<const Codebook> codebook,
    const IndexOptions& options, const std::optional<SessionAccuracy>& accuracy = {});

// A tile in the anchor frame of one query.
struct TileView {
  std::shared_ptr<const SearchableTile> tile;
  Rigid3d anchor_from_tile;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_
