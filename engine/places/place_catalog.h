// Keeps the index of a map's places up to date with the versions of the map.
#ifndef CAIRN_ENGINE_PLACES_PLACE_CATALOG_H_
#define CAIRN_ENGINE_PLACES_PLACE_CATALOG_H_

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/stop_function.h"
#include "engine/places/place_index.h"
#include "engine/places/places_options.h"
#include "engine/tiles/map_tiles.h"
#include "storage/map/map_store.h"

namespace cairn {

struct CataloguedPlaces {
  std::shared_ptr<const PlaceIndex> index;  // Null if the map is empty.
  // False if the deadline left tiles out.
  bool is_complete = true;
};

// The index of a version takes over what it shares with the version before: the signatures of tiles
// that have not changed, and the segments in which no tile has changed. Safe to use from any
// thread.
class PlaceCatalog {
 public:
  // `options` must outlive the object.
  explicit PlaceCatalog(const PlacesOptions* options) : options_(options) {}

  // Returns the index of `map`, which is this version of a map. Reads and decodes the tiles that no
  // earlier call has read, on all cores; threads that ask for an index meanwhile wait for it. Polls
  // `should_stop`. Once it returns true, the index lacks the tiles that were not read yet, and the
  // next call goes on. Throws Error(kMapDamaged) if a tile does not decode or has another codebook
  // than the current one, and what the calls of MapTiles throw.
  CataloguedPlaces IndexOf(const MapTiles& map, MapVersion version,
                           const StopFunction& should_stop = {});

 private:
  using Signatures = std::unordered_map<std::string, SharedSignature>;  // By digest of the tile.

  CataloguedPlaces Update(const MapTiles& map, const StopFunction& should_stop);
  // Returns the largest power of two of descriptors a tile within the options' bounds.
  size_t DescriptorsPerTile(size_t num_tiles, const Codebook& codebook) const;
  // Makes the missing signatures of the tiles. Returns false if it stopped before the end.
  bool ReadSignatures(const MapTiles& map, const std::vector<TileRecord>& tiles,
                      size_t max_descriptors, const StopFunction& should_stop);
  std::vector<SharedSegment> MakeSegments(const std::vector<TileRecord>& tiles,
                                          const std::shared_ptr<const Codebook>& codebook) const;

  const PlacesOptions* options_;
  std::timed_mutex mutex_;  // Guards all below.
  std::optional<MapVersion> version_;
  CataloguedPlaces current_;
  size_t max_descriptors_ = 0;  // Of a tile, in signatures_.
  Signatures signatures_;       // Of the version's tiles.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_PLACES_PLACE_CATALOG_H_
