// The served map. Another file may replace the map while queries run.
#ifndef CAIRN_HTTP_SERVICE_SERVED_MAP_H_
#define CAIRN_HTTP_SERVICE_SERVED_MAP_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/localizer.h"
#include "storage/map/map_store.h"
#include "storage/map/pinned_file.h"

namespace cairn {

// What changes if somebody writes to a file. For a PostgreSQL URL, some constant.
struct FileStamp {
  std::filesystem::file_time_type written_at;
  uintmax_t num_bytes = 0;

  static FileStamp Of(const std::string& path);
  bool operator==(const FileStamp&) const = default;
};

// An open map file. A query that holds a ServedMap uses this file even after another file has
// replaced it.
struct ServedMap {
  std::unique_ptr<Localizer> localizer;
  std::string created_at;
  MapVersion version_when_opened{};
  // True if another map with the same name was still open when this one was opened. Such a map does
  // not share the write-ahead log beside the file. It is opened again when the other map is closed.
  bool is_stand_in = false;
  // True if the file is mounted without its folder, as `docker run --volume town.gpkg:/town.gpkg`
  // does it. The write-ahead log of its writers is then invisible, and so is a file that takes the
  // name in the folder.
  bool is_mounted_alone = false;
  FileStamp stamp;                        // Of the file just before it was opened.
  std::shared_ptr<const PinnedFile> log;  // The write-ahead log beside the file, if there was one.

  const MapStore& store() const { return localizer->map(); }

  // Identifies the contents of a tile, for ETag. Different bytes have different tags, also across
  // maps.
  std::string TileTag(const TileRecord& tile) const;
};

struct ServedMapOptions {
  std::string path;
  size_t cache_bytes = kDefaultCacheBytes;
  LocalizerOptions localizer = {};
};

// Safe to call from any thread.
class ServedMaps {
 public:
  // Opens the map; throws as MapStore::Open.
  explicit ServedMaps(const ServedMapOptions& options);

  std::shared_ptr<const ServedMap> Current() const;

  // Checks whether another file has taken the map's path, or the file was overwritten in place, as
  // `cp` does it. If there is another map then, serves it from then on; otherwise keeps the old
  // map. A map in an overwritten file is served when the file has not changed between two calls.
  // Call Refresh about once a second. Does not throw.
  void Refresh();
  // Like Refresh, but opens the file even if it seems unchanged or still changes.
  void Reload();

  // Returns the reason why the served map is not the file at its path or is not kept up to date.
  // Empty if there is no problem. The text contains no path; the log has the details.
  std::string Problem() const;

 private:
  std::shared_ptr<ServedMap> Open(OpenMode mode) const;
  // With the tiles that are in memory already.
  std::shared_ptr<ServedMap> Open(OpenMode mode, std::shared_ptr<TileCache> cache) const;
  void Look(bool is_forced);
  // Releases replaced maps that no query holds any more. Returns true if none is left.
  bool ReleaseReplaced();
  void ReplaceCurrent(std::shared_ptr<const ServedMap> next);
  void TakeReplacement();
  void TakeOverwritten();
  void Take(std::shared_ptr<ServedMap> next);
  // Opens the file again if it has changed. The change may be an update of the map, which the open
  // map sees, or a copy over the map. SQLite would mix pages of the two.
  void FollowWrites(const ServedMap& current);
  // Opens a map that is mounted alone again if its file has changed. SQLite would mix old and new
  // pages, because it learns of changes from the log only.
  void FollowMountedFile(const ServedMap& current);
  void TakePlaceOfStandIn();
  bool LogIsOfReplacedMap(const std::string& log_path) const;
  void SetProblem(const std::string& problem, const std::string& detail);

  const ServedMapOptions options_;
  std::mutex look_mutex_;               // Held during a check; guards the next five members.
  bool must_reload_ = false;            // Reload found a file that cannot be opened.
  FileStamp checked_;                   // Of the file when it last held the served map.
  std::optional<FileStamp> unsettled_;  // Of a file with another map that may be incomplete.
  std::vector<std::shared_ptr<const ServedMap>> replaced_;
  std::shared_ptr<const PinnedFile>
      replaced_log_;          // The log of the map that the stand-in replaced.
  mutable std::mutex mutex_;  // Guards the next two members.
  std::shared_ptr<const ServedMap> current_;
  std::string problem_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_SERVED_MAP_H_
