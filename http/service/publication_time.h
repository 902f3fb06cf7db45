// When the head of a map was published.
#ifndef CAIRN_HTTP_SERVICE_PUBLICATION_TIME_H_
#define CAIRN_HTTP_SERVICE_PUBLICATION_TIME_H_

#include <mutex>
#include <optional>
#include <string>

#include "storage/map/map_store.h"

namespace cairn {

// Returns the seconds since 1970 of a time such as "2026-01-31T12:00:00Z"; 0 if the text is none.
double UnixSeconds(const std::string& utc);

// Remembers the last answer, so that asking often reads the map once a version. Safe to call from
// any thread.
class PublicationTime {
 public:
  // Returns when the snapshot's version was published, seconds since 1970, or nothing if the map
  // cannot be read. `map_created_at` tells maps apart whose versions have equal numbers. If the
  // store is silent, does not wait for it.
  std::optional<double> UnixSecondsOf(const MapSnapshot& snapshot,
                                      const std::string& map_created_at);

 private:
  std::mutex mutex_;
  std::string map_created_at_;
  MapVersion version_{};
  std::optional<double> unix_s_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_PUBLICATION_TIME_H_
