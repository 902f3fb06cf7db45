#include "ingest/scratch_map.h"

#include <optional>
#include <string>
#include <utility>

#include "ingest/temporary_folder.h"
#include "ingest/tile_rewriter.h"
#include "ingest/write_tile.h"
#include "storage/codebook/codebook.h"

namespace cairn {

struct ScratchMap::Impl {
  TemporaryFolder folder;
  MapStore store = MapStore::Create(folder.path() + "/scratch.gpkg");
};

ScratchMap::ScratchMap() : impl_(std::make_unique<Impl>()) {}
ScratchMap::ScratchMap(ScratchMap&&) noexcept = default;
ScratchMap::~ScratchMap() = default;

MapStore& ScratchMap::store() const { return impl_->store; }

ScratchMap MapWithoutSession(const std::vector<TileId>& tiles, SessionId without,
                             const MapSnapshot& map) {
  ScratchMap scratch;
  const std::shared_ptr<const Codebook> codebook = map.CurrentCodebook();
  if (codebook == nullptr) {
    return scratch;
  }
  MapUpdate copy = scratch.store().BeginUpdate();
  Codebook own_codebook = *codebook;
  own_codebook.id = copy.AddCodebook(*codebook);
  for (const TileId tile_id : tiles) {
    std::optional<Tile> tile = LoadWithoutSession(tile_id, without, map);
    if (!tile || tile->codebook_id != codebook->id) {
      continue;
    }
    tile->codebook_id = own_codebook.id;
    WriteTile(*tile, own_codebook, &copy);
  }
  copy.Publish({.kind = VersionKind::kExtract});
  return scratch;
}

}  // namespace cairn
