// When photos were taken, as people write times.
#ifndef CAIRN_CLI_RECORDING_TIME_H_
#define CAIRN_CLI_RECORDING_TIME_H_

#include <string>

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

// Adds --recorded, which takes what UtcTimeOf takes.
void AddRecordedOption(CLI::App* command, const std::string& description, std::string* recorded_at);

// The time of an ISO 8601 text in UTC, as maps store it: "2026-01-31T12:00:00Z". Reads a date,
// which stands for its first second; and a time with Z or an offset such as +01:00, with or without
// fractions of a second, which are dropped. Another text is returned as it is.
std::string UtcTimeOf(const std::string& text);

// Logs a warning if a time in UTC is more than a day ahead of the clock.
void WarnOfFuture(const std::string& recorded_at);

}  // namespace cairn

#endif  // CAIRN_CLI_RECORDING_TIME_H_
