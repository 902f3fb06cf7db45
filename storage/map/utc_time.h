// Times as a map stores them; private to storage and ingest.
#ifndef CAIRN_STORAGE_MAP_UTC_TIME_H_
#define CAIRN_STORAGE_MAP_UTC_TIME_H_

#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>

namespace cairn {

// Returns the current time, as "2026-01-31T12:00:00Z".
inline std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[sizeof("2026-01-31T12:00:00Z")];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

// Returns true for a valid time such as "2026-01-31T12:00:00Z". Such times sort as text.
inline bool IsUtcTime(const std::string& text) {
  constexpr size_t kSize = 20;
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, end = 0;
  const bool has_form = text.size() == kSize &&
                        text.find_first_not_of("0123456789-:TZ") == std::string::npos &&
                        std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:%2dZ%n", &year, &month, &day,
                                    &hour, &minute, &second, &end) == 6 &&
                        end == static_cast<int>(kSize);
  return has_form && year >= 0 && hour < 24 && minute < 60 && second < 60 && hour >= 0 &&
         minute >= 0 && second >= 0 &&
         std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(unsigned(month)),
                                     std::chrono::day(unsigned(day)))
             .ok();
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_UTC_TIME_H_
