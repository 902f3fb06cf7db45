#include "cli/recording_time.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>
#include <string_view>

#include "core/logging.h"
#include "core/printable.h"

namespace cairn {
namespace {

using Seconds = std::chrono::sys_seconds;

// True if the text has digits where the form has zeros, and else the letters of the form.
bool HasForm(std::string_view text, std::string_view form) {
  return std::equal(text.begin(), text.end(), form.begin(), form.end(), [](char letter, char sign) {
    return sign == '0' ? letter >= '0' && letter <= '9' : letter == sign;
  });
}

int NumberAt(std::string_view text, size_t at, size_t num_digits) {
  int number = 0;
  std::from_chars(text.data() + at, text.data() + at + num_digits, number);
  return number;
}

// The time of "2026-01-31T12:00:00"; nothing if there is no such time.
std::optional<Seconds> TimeOfDigits(std::string_view text) {
  if (!HasForm(text, "0000-00-00T00:00:00")) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{
      std::chrono::year(NumberAt(text, 0, 4)),
      std::chrono::month(static_cast<unsigned>(NumberAt(text, 5, 2))),
      std::chrono::day(static_cast<unsigned>(NumberAt(text, 8, 2)))};
  const int hour = NumberAt(text, 11, 2), minute = NumberAt(text, 14, 2);
  const int second = NumberAt(text, 17, 2);
  if (!date.ok() || hour > 23 || minute > 59 || second > 59) {
    return std::nullopt;
  }
  return std::chrono::sys_days(date) + std::chrono::hours(hour) + std::chrono::minutes(minute) +
         std::chrono::seconds(second);
}

// How far the clocks of a zone such as "Z" or "+01:00" are ahead of UTC.
std::optional<std::chrono::minutes> OffsetOf(std::string_view zone) {
  if (zone == "Z") {
    return std::chrono::minutes(0);
  }
  if (!HasForm(zone, "+00:00") && !HasForm(zone, "-00:00")) {
    return std::nullopt;
  }
  const int hours = NumberAt(zone, 1, 2), minutes = NumberAt(zone, 4, 2);
  if (hours > 14 || minutes > 59) {
    return std::nullopt;
  }
  return std::chrono::minutes((zone.front() == '-' ? -1 : 1) * (60 * hours + minutes));
}

std::string UtcTextOf(Seconds time) {
  const auto days = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(days);
  const std::chrono::hh_mm_ss clock(time - days);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     clock.hours().count(), clock.minutes().count(), clock.seconds().count());
}

}  // namespace

void AddRecordedOption(CLI::App* command, const std::string& description,
                       std::string* recorded_at) {
  command
      ->add_option_function<std::string>(
          "--recorded", [recorded_at](const std::string& text) { *recorded_at = UtcTimeOf(text); },
          description)
      ->type_name("UTC");
}

std::string UtcTimeOf(const std::string& text) {
  constexpr size_t kDigitsSize = 19;
  if (HasForm(text, "0000-00-00")) {
    return text + "T00:00:00Z";
  }
  const std::string_view all = text;
  const std::optional<Seconds> time = TimeOfDigits(all.substr(0, kDigitsSize));
  if (!time) {
    return text;
  }
  std::string_view zone = all.substr(kDigitsSize);
  if (zone.starts_with('.')) {
    zone.remove_prefix(std::min(zone.find_first_not_of("0123456789", 1), zone.size()));
  }
  const std::optional<std::chrono::minutes> offset = OffsetOf(zone);
  return offset ? UtcTextOf(*time - *offset) : text;
}

void WarnOfFuture(const std::string& recorded_at) {
  const auto tomorrow = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()) +
                        std::chrono::days(1);
  if (recorded_at > UtcTextOf(tomorrow)) {  // Such times sort as text.
    LogWarning(
        "--recorded {}: this time is in the future; landmarks of other sessions fade by it. If it "
        "is wrong, ingest the session again with the right one",
        Printable(recorded_at));
  }
}

}  // namespace cairn
