#include "core/logging.h"

#include <spdlog/spdlog.h>

#include <memory>
#include <string>

#include "core/log_sink.h"
#include "core/printable.h"

namespace cairn {
namespace {

spdlog::level::level_enum SpdlogLevel(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kOff:
      break;
  }
  return spdlog::level::off;
}

spdlog::logger& Logger() {
  static const std::shared_ptr<spdlog::logger> logger = [] {
    auto made = std::make_shared<spdlog::logger>("cairn", LogSink());
    made->set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
    return made;
  }();
  return *logger;
}

}  // namespace

void SetLogLevel(LogLevel level) { Logger().set_level(SpdlogLevel(level)); }

bool LogEnabled(LogLevel level) { return Logger().should_log(SpdlogLevel(level)); }

void WriteLog(LogLevel level, std::string_view message) noexcept {
  try {
    const std::string line = Printable(message);
    Logger().log(SpdlogLevel(level), spdlog::string_view_t(line.data(), line.size()));
  } catch (...) {
    // A failure to log must not stop the work that the log describes.
  }
}

}  // namespace cairn
