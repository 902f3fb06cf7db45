// Logging to stderr, formatted with {fmt}. Implemented with spdlog.
#ifndef CAIRN_CORE_LOGGING_H_
#define CAIRN_CORE_LOGGING_H_

#include <fmt/format.h>

#include <string_view>
#include <utility>

namespace cairn {

enum class LogLevel { kDebug, kInfo, kWarning, kError, kOff };

// Drops messages below `level`. Thread-safe. The default is kInfo.
void SetLogLevel(LogLevel level);

// Writes one line, escaped as Printable does. Thread-safe; never throws.
void WriteLog(LogLevel level, std::string_view message) noexcept;

// Returns true if a message of this level would be written.
bool LogEnabled(LogLevel level);

template <typename... Args>
void Log(LogLevel level, fmt::format_string<Args...> format, Args&&... args) {
  if (LogEnabled(level)) {
    WriteLog(level, fmt::format(format, std::forward<Args>(args)...));
  }
}

template <typename... Args>
void LogDebug(fmt::format_string<Args...> format, Args&&... args) {
  Log(LogLevel::kDebug, format, std::forward<Args>(args)...);
}

template <typename... Args>
void LogInfo(fmt::format_string<Args...> format, Args&&... args) {
  Log(LogLevel::kInfo, format, std::forward<Args>(args)...);
}

template <typename... Args>
void LogWarning(fmt::format_string<Args...> format, Args&&... args) {
  Log(LogLevel::kWarning, format, std::forward<Args>(args)...);
}

template <typename... Args>
void LogError(fmt::format_string<Args...> format, Args&&... args) {
  Log(LogLevel::kError, format, std::forward<Args>(args)...);
}

}  // namespace cairn

#endif  // CAIRN_CORE_LOGGING_H_
