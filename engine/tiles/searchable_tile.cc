#include "engine/tiles/searchable_tile.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

// Hands the tile on if its codes can be read with the codebook.
Tile RequireCodebook(Tile tile, const Codebook& codebook) {
  if (tile.codebook_id != codebook.id || tile.code_size != codebook.num_subspaces) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("tile {} has {}-byte codes of codebook {}, but codebook {} has {}-byte "
                            "codes; run `cairn info --check` on the map",
                            tile.id.ToString(), tile.code_size, Value(tile.codebook_id),
                            Value(codebook.id), codebook.num_subspaces));
  }
  return tile;
}

std::vector<uint32_t> LandmarkOfDescriptor(const Tile& tile) {
  std::vector<uint32_t> landmark_of_descriptor(tile.num_descriptors());
  for (uint32_t landmark = 0; landmark < tile.num_landmarks(); ++landmark) {
    std::fill(landmark_of_descriptor.begin() + tile.descriptor_begin[landmark],
              landmark_of_descriptor.begin() + tile.descriptor_begin[landmark + 1], landmark);
  }
  return landmark_of_descriptor;
}

}  // namespace

SearchableTile::SearchableTile(Tile tile, std::shared_ptr<const Codebook> codebook,
                               const IndexOptions& options, TileLists lists)
    : tile_(RequireCodebook(std::move(tile), *codebook)),
      codebook_(std::move(codebook)),
      ecef_from_tile_(EcefFromEnu(tile_.id.Anchor())),
      landmark_of_descriptor_(LandmarkOfDescriptor(tile_)),
      index_(MakeMatchingIndex(*codebook_, tile_.codes, options, std::move(lists))) {
  if (options.num_reference_words > 0) {
    constexpr int kNumIterations = 5;
    constexpr uint64_t kSeed = 1;
    reference_words_.emplace(ByteDescriptors(*codebook_, tile_.codes), options.num_reference_words,
                             kNumIterations, kSeed);
  }
}

std::vector<double> SearchableTile::ReferenceDistances(const DescriptorMatrix& queries) const {
  return reference_words_ ? reference_words_->NearestDistances(ByteScale(*codebook_), queries)
                          : std::vector<double>(queries.rows(), 0.0);
}

size_t SearchableTile::MemoryBytes() const {
  return sizeof(*this) + tile_.MemoryBytes() +
         landmark_of_descriptor_.capacity() * sizeof(uint32_t) + index_->MemoryBytes() +
         (reference_words_ ? reference_words_->MemoryBytes() : 0);
}

}  // namespace cairn
