#include "engine/places/place_catalog.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/parallel_for.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// Tiles of one block share a segment. A block is large enough that a search of a segment compares
// more descriptors than words, and small enough that the update of a tile rebuilds little.
struct Block {
  static constexpr int kTilesPerSide = 4;

  explicit Block(TileId tile)
      : zone(tile.north() ? tile.zone() : -1 - tile.zone()),
        x(tile.easting_idx() / kTilesPerSide),
        y(tile.northing_idx() / kTilesPerSide) {}

  bool operator<(const Block& other) const {
    return std::tie(zone, y, x) < std::tie(other.zone, other.y, other.x);
  }

  int zone;  // Negative in the south.
  int x, y;
};

SharedSignature SignatureOf(const Tile& tile, TileId tile_id, size_t max_descriptors) {
  if (tile.id != tile_id) {
    throw Error(ErrorCode::kMapDamaged, "holds tile " + tile.id.ToString());
  }
  return std::make_shared<const TileSignature>(MakeTileSignature(tile, max_descriptors));
}

SharedSignature ReadSignature(const MapTiles& map, const TileRecord& tile, size_t max_descriptors) {
  try {
    const StoredTile stored = map.LoadTile(tile);
    return stored.decoded != nullptr
               ? SignatureOf(stored.decoded->tile, tile.tile_id, max_descriptors)
               : SignatureOf(DecodeTile(stored.payload), tile.tile_id, max_descriptors);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("tile {}, payload {}: {}", tile.tile_id.ToString(),
                                          Value(tile.payload_id), error.what()));
  }
}

void RequireCodebook(const std::vector<TileRecord>& tiles, const Codebook& codebook) {
  for (const TileRecord& tile : tiles) {
    if (tile.codebook_id != codebook.id) {
      throw Error(ErrorCode::kMapDamaged,
                  fmt::format("tile {} is coded with codebook {}, which is not the map's current "
                              "one; ingest its sessions again",
                              tile.tile_id.ToString(), Value(tile.codebook_id)));
    }
  }
}

}  // namespace

size_t PlaceCatalog::DescriptorsPerTile(size_t num_tiles, const Codebook& codebook) const {
  const size_t max_bytes_per_tile = options_->max_bytes / std::max<size_t>(1, num_tiles);
  auto size = static_cast<size_t>(options_->max_descriptors_per_tile);
  while (size > 1 && size * PlaceSegment::BytesPerDescriptor(codebook) > max_bytes_per_tile) {
    size /= 2;
  }
  return size;
}

bool PlaceCatalog::ReadSignatures(const MapTiles& map, const std::vector<TileRecord>& tiles,
                                  size_t max_descriptors, const StopFunction& should_stop) {
  Signatures kept;
  std::vector<const TileRecord*> missing;
  for (const TileRecord& tile : tiles) {
    const auto found = signatures_.find(tile.digest);
    if (max_descriptors == max_descriptors_ && found != signatures_.end()) {
      kept.insert(*found);
    } else {
      missing.push_back(&tile);
    }
  }
  std::vector<SharedSignature> read(missing.size());
  const auto num_missing = static_cast<int>(missing.size());
  ParallelFor(num_missing, std::min(NumCores(), std::max(1, num_missing)), [&](int i) {
    if (!should_stop || !should_stop()) {
      read[i] = ReadSignature(map, *missing[i], max_descriptors);
    }
  });
  bool is_complete = true;
  for (size_t i = 0; i < missing.size(); ++i) {
    if (read[i] != nullptr) {
      kept.emplace(missing[i]->digest, std::move(read[i]));
    } else {
      is_complete = false;
    }
  }
  signatures_ = std::move(kept);
  max_descriptors_ = max_descriptors;
  return is_complete;
}

std::vector<SharedSegment> PlaceCatalog::MakeSegments(
    const std::vector<TileRecord>& tiles, const std::shared_ptr<const Codebook>& codebook) const {
  std::map<Block, std::vector<SharedSignature>> blocks;
  for (const TileRecord& tile : tiles) {
    if (const auto found = signatures_.find(tile.digest); found != signatures_.end()) {
      blocks[Block(tile.tile_id)].push_back(found->second);
    }
  }
  std::map<std::vector<SharedSignature>, SharedSegment> known;
  if (current_.index != nullptr && current_.index->codebook().id == codebook->id) {
    for (const SharedSegment& segment : current_.index->segments()) {
      known.emplace(segment->tiles(), segment);
    }
  }
  std::vector<std::vector<SharedSignature>> of_blocks;
  for (auto& [block, signatures] : blocks) {
    of_blocks.push_back(std::move(signatures));
  }
  std::vector<SharedSegment> segments(of_blocks.size());
  const auto num_segments = static_cast<int>(segments.size());
  ParallelFor(num_segments, std::min(NumCores(), std::max(1, num_segments)), [&](int i) {
    const auto found = known.find(of_blocks[i]);
    segments[i] = found != known.end()
                      ? found->second
                      : std::make_shared<const PlaceSegment>(*codebook, std::move(of_blocks[i]));
  });
  return segments;
}

CataloguedPlaces PlaceCatalog::Update(const MapTiles& map, const StopFunction& should_stop) {
  const std::shared_ptr<const Codebook> codebook = map.CurrentCodebook();
  if (codebook == nullptr) {
    return {};
  }
  const std::vector<TileRecord> tiles = map.FindTiles(WholeEarth());
  RequireCodebook(tiles, *codebook);
  const bool is_complete =
      ReadSignatures(map, tiles, DescriptorsPerTile(tiles.size(), *codebook), should_stop);
  return {std::make_shared<const PlaceIndex>(codebook, MakeSegments(tiles, codebook)), is_complete};
}

CataloguedPlaces PlaceCatalog::IndexOf(const MapTiles& map, MapVersion version,
                                       const StopFunction& should_stop) {
  constexpr std::chrono::milliseconds kPollInterval(2);
  std::unique_lock lock(mutex_, std::defer_lock);
  while (should_stop && !lock.try_lock_for(kPollInterval)) {
    if (should_stop()) {
      return {nullptr, false};
    }
  }
  if (!lock.owns_lock()) {
    lock.lock();
  }
  if (version_ != version || !current_.is_complete) {
    current_ = Update(map, should_stop);
    version_ = version;
  }
  return current_;
}

}  // namespace cairn
