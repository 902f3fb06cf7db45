// Localizes many photos on all cores.
#ifndef CAIRN_CLI_BATCH_LOCALIZE_PHOTOS_H_
#define CAIRN_CLI_BATCH_LOCALIZE_PHOTOS_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "cli/batch/photo_list.h"
#include "cli/batch/photo_query.h"
#include "cli/batch/result_file.h"
#include "cli/batch/world_frame.h"
#include "engine/query/localize_result.h"

namespace cairn {

// Answers the query of a photo, whose features it may add.
using PhotoAnswerer = std::function<LocalizeResult(PhotoQuery* photo)>;

struct LocalizePhotosOptions {
  PhotoQueryOptions query;  // For what the photo's own ListedPhoto leaves open.
  WorldFrame frame;
  int num_threads = 1;  // The rows do not depend on it.
  // Each thread has an answerer of its own.
  std::function<PhotoAnswerer()> make_answerer;
  // Called by one thread at a time.
  std::function<void(int64_t done, int64_t total)> progress = {};
};

// Appends the rows that `results` lacks, in the order of the photos. A photo that cannot be read or
// asked gets a row that says why. Throws what would fail for all other photos, too: Error
// kUnavailable, kMapDamaged and kConflict, a server that does not accept the client, or a front
// without its server (ServerRefusal), and Error(kIo) if the map cannot be read or the file cannot
// be written; rows that were complete are kept.
void LocalizePhotos(const std::vector<ListedPhoto>& photos, const LocalizePhotosOptions& options,
                    ResultFile* results);

}  // namespace cairn

#endif  // CAIRN_CLI_BATCH_LOCALIZE_PHOTOS_H_
