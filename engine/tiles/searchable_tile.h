// A tile in the form the engine searches: with its matching index built.
#ifndef CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_
#define CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geodesy.h"
#include "core/large_vector.h"
#include "engine/index/inverted_lists.h"
#include "engine/index/matching_index.h"
#include "engine/index/product_words.h"
#include "engine/tiles/descriptor_places.h"
#include "engine/tiles/tile_content.h"
#include "storage/codebook/codebook.h"
#include "storage/map/tile_cache.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_lists.h"
#include "storage/tile/tile_payload.h"

namespace cairn {

// Shared by queries through the cache. Safe to use from any thread.
class SearchableTile : public CachedTile {
 public:
  // Builds the index, or the first part of it. `tile` must be consistent (as DecodeTile returns
  // it). Throws Error(kMapDamaged) if `codebook` is not the tile's, and as MakeMatchingIndex.
  // `lists` are the tile's, if it has any.
  SearchableTile(Tile tile, std::shared_ptr<const Codebook> codebook, const IndexOptions& options,
                 TileLists lists = {}, BuildExtent extent = BuildExtent::kWhole);

  // True if these options search a payload by its own lists and need nothing else of it.
  static bool NeedsListsOnly(const IndexOptions& options);
  // For such options: searches by the payload's lists; the rest of it is decoded when a query asks
  // for it. Throws as the other.
  SearchableTile(TilePayload payload, std::shared_ptr<const Codebook> codebook,
                 const IndexOptions& options);
  // For options without reference words: the same with an index of any kind, made of the payload's
  // codes in the order of the tile. Throws as the other.
  SearchableTile(TilePayload payload, std::shared_ptr<const Codebook> codebook,
                 const IndexOptions& options, LargeVector<uint8_t> codes, BuildExtent extent);

  TileId id() const { return id_; }
  size_t num_descriptors() const { return num_descriptors_; }
  const Codebook& codebook() const { return *codebook_; }
  const MatchingIndex& index() const { return *index_; }
  // Distance in projected space from each query (n x dim) to the nearest of the reference words; 0
  // if the options ask for none. Throws Error(kInternal) if the dimension is another.
  std::vector<double> ReferenceDistances(const DescriptorMatrix& queries) const;
  const Rigid3d& ecef_from_tile() const { return ecef_from_tile_; }

  // Decodes what matching needs, so that it need not wait. Throws as what follows.
  void Prepare() const { content_.places(); }

  // All may have to wait for that half of the tile to be decoded: what matching needs, or the rest.
  // Throw Error(kMapDamaged) if it cannot be.
  const TileLandmarks& landmarks() const { return content_.landmarks(); }
  // In the order of the index.
  const DescriptorPlaces& places() const { return content_.places(); }
  const TileCovisibility& covisibility() const { return content_.covisibility(); }
  // num_descriptors() x codebook().num_subspaces, in the order of the tile.
  std::span<const uint8_t> codes() const { return content_.codes(); }
  // Of both halves.
  const LandmarkSightings& sightings() const { return content_.sightings(); }

  size_t MemoryBytes() const override;

 private:
  SearchableTile(TilePayload&& payload, std::shared_ptr<const Codebook> codebook,
                 std::unique_ptr<const InvertedLists> index);

  TileId id_;
  size_t num_descriptors_;
  std::shared_ptr<const Codebook> codebook_;
  Rigid3d ecef_from_tile_;
  std::unique_ptr<const MatchingIndex> index_;
  std::optional<ProductWords> reference_words_;
  TileContent content_;
};

// Makes a payload, as LoadPayload returns it, searchable in the quickest way, or at least the first
// part of its index. Throws Error(kMapDamaged) if it does not decode or is not of the codebook.
std::shared_ptr<const SearchableTile> MakeSearchableTile(LargeVector<uint8_t> payload,
                                                         std::shared_ptr<const Codebook> codebook,
                                                         const IndexOptions& options);

// A tile as one query sees it.
struct TileView {
  std::shared_ptr<const SearchableTile> tile;
  Rigid3d anchor_from_tile;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_
