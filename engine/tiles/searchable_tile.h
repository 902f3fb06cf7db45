// A tile in the form the engine searches: decoded, with its matching index built.
#ifndef CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_
#define CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "core/geodesy.h"
#include "engine/matching/matching_index.h"
#include "engine/matching/product_words.h"
#include "storage/codebook.h"
#include "storage/tile.h"
#include "storage/tile_cache.h"
#include "storage/tile_lists.h"

namespace cairn {

// Immutable after construction; shared by queries through the cache.
class SearchableTile : public CachedTile {
 public:
  // Builds the index. `tile` must be consistent (as DecodeTile returns it). Throws
  // Error(kMapDamaged) if `codebook` is not the tile's, and as MakeMatchingIndex. `lists` are the
  // tile's, if it has any.
  SearchableTile(Tile tile, std::shared_ptr<const Codebook> codebook, const IndexOptions& options,
                 TileLists lists = {});

  const Tile& tile() const { return tile_; }
  const Codebook& codebook() const { return *codebook_; }
  const MatchingIndex& index() const { return *index_; }
  // Distance in projected space from each query (n x dim) to the nearest of the reference words; 0
  // if the options ask for none. Throws Error(kInternal) if the dimension is another.
  std::vector<double> ReferenceDistances(const DescriptorMatrix& queries) const;
  const Rigid3d& ecef_from_tile() const { return ecef_from_tile_; }
  // Landmark of each descriptor.
  const std::vector<uint32_t>& landmark_of_descriptor() const { return landmark_of_descriptor_; }

  size_t MemoryBytes() const override;

 private:
  Tile tile_;
  std::shared_ptr<const Codebook> codebook_;
  Rigid3d ecef_from_tile_;
  std::vector<uint32_t> landmark_of_descriptor_;
  std::unique_ptr<const MatchingIndex> index_;
  std::optional<ProductWords> reference_words_;
};

// A tile as one query sees it.
struct TileView {
  std::shared_ptr<const SearchableTile> tile;
  Rigid3d anchor_from_tile;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_SEARCHABLE_TILE_H_
