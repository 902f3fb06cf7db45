#include "http/service/publication_time.h"

#include <chrono>
#include <cstdio>
#include <vector>

#include "core/error.h"
#include "core/logging.h"

namespace cairn {
namespace {

std::optional<double> ReadTime(const MapSnapshot& snapshot) {
  if (snapshot.is_stale()) {
    return std::nullopt;
  }
  try {
    const std::vector<VersionRecord> versions = snapshot.Versions(/*limit=*/1);
    return versions.empty() ? std::nullopt
                            : std::optional(UnixSeconds(versions.front().created_at));
  } catch (const Error& e) {
    LogError("the map cannot be read: {}", e.what());
    return std::nullopt;
  }
}

}  // namespace

double UnixSeconds(const std::string& utc) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  if (std::sscanf(utc.c_str(), "%4d-%2d-%2dT%2d:%2d:%2dZ", &year, &month, &day, &hour, &minute,
                  &second) != 6) {
    return 0.0;
  }
  const std::chrono::year_month_day date(std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day)));
  const std::chrono::sys_days midnight(date);
  return std::chrono::duration<double>(midnight.time_since_epoch()).count() + 3600.0 * hour +
         60.0 * minute + second;
}

std::optional<double> PublicationTime::UnixSecondsOf(const MapSnapshot& snapshot,
                                                     const std::string& map_created_at) {
  const std::lock_guard lock(mutex_);
  const bool is_known =
      unix_s_ && version_ == snapshot.version() && map_created_at_ == map_created_at;
  if (!is_known) {
    unix_s_ = ReadTime(snapshot);
    version_ = snapshot.version();
    map_created_at_ = map_created_at;
  }
  return unix_s_;
}

}  // namespace cairn
