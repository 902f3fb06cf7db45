// Finds the time at which the latest version of a map was published.
#ifndef CAIRN_HTTP_SERVICE_PUBLICATION_TIME_H_
#define CAIRN_HTTP_SERVICE_PUBLICATION_TIME_H_

#include <mutex>
#include <optional>
#include <string>

#include "storage/map/map_store.h"

namespace cairn {

// Returns the seconds since 1970 of a time such as "2026-01-31T12:00:00Z"; 0 if the text is not a
// time.
double UnixSeconds(const std::string& utc);

// Remembers the last answer, so each version is read from the map once. Safe to call from any
// thread.
class PublicationTime {
 public:
  // Returns the time at which the snapshot's version was published, seconds since 1970, or nothing
  // if the map cannot be read. Versions of two maps may have equal numbers; `map_created_at` tells
  // the maps apart. Does not wait for PostgreSQL while it is silent.
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
