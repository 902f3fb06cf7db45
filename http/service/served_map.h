// The map that is being served, which may be replaced by another file while queries run.
#ifndef CAIRN_HTTP_SERVICE_SERVED_MAP_H_
#define CAIRN_HTTP_SERVICE_SERVED_MAP_H_

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "engine/localizer.h"
#include "storage/map/map_store.h"
#include "storage/map/pinned_file.h"
#include "storage/map/tile_cache.h"

namespace cairn {

// One map file, opened. Whoever holds it is served from this file, also when it has been replaced.
struct ServedMap {
  std::shared_ptr<const MapStore> store;
  std::shared_ptr<TileCache> cache;  // Of tiles of this file only: payload ids are per file.
  std::unique_ptr<Localizer> localizer;
  std::string created_at;
  MapVersion version_when_opened{};
  // Another map was open under the name when this one was opened, so this one does not share the
  // write-ahead log beside it; it is opened again when the other is closed.
  bool is_stand_in = false;
  std::shared_ptr<const PinnedFile> log;  // The write-ahead log beside it, if there was one.

  // Names the contents of a tile, for ETag: differs whenever the bytes differ, also between maps.
  std::string TileTag(const TileRecord& tile) const;
};

struct ServedMapOptions {
  std::string path;
  size_t cache_bytes = size_t{1} << 30;
  LocalizerOptions localizer = {};
};

// Safe to call from any thread.
class ServedMaps {
 public:
  // Opens the map; throws as MapStore::Open.
  explicit ServedMaps(const ServedMapOptions& options);

  std::shared_ptr<const ServedMap> Current() const;

  // Looks whether another file stands under the name, and serves it from then on if it is a map;
  // otherwise the old one stays. To be called about once a second. Does not throw.
  void Refresh();
  // As Refresh, and opens the file even if it seems to be the same one: it may have been
  // overwritten in place. Serves it if it holds another map.
  void Reload();

  // Why the served map is not what stands under the name, or is not kept up to date, in words that
  // name no path; empty if all is well. The log has more.
  std::string Problem() const;

 private:
  std::shared_ptr<ServedMap> Open(OpenMode mode, std::shared_ptr<TileCache> cache) const;
  void Look(bool is_forced);
  // Lets go of replaced maps that no query holds any more; true if there is none left.
  bool ReleaseReplaced();
  void ReplaceCurrent(std::shared_ptr<const ServedMap> next);
  void TakeReplacement();
  void TakeOverwritten();
  void TakePlaceOfStandIn();
  bool LogIsOfReplacedMap(const std::string& log_path) const;
  void SetProblem(const std::string& problem, const std::string& detail);

  const ServedMapOptions options_;
  std::mutex look_mutex_;     // Held while looking; of the next three.
  bool must_reload_ = false;  // Reload found what cannot be opened.
  std::vector<std::shared_ptr<const ServedMap>> replaced_;
  std::shared_ptr<const PinnedFile> replaced_log_;  // Of the map before the stand-in.
  mutable std::mutex mutex_;                        // Of the next two.
  std::shared_ptr<const ServedMap> current_;
  std::string problem_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_SERVED_MAP_H_
