#include "http/exchange/http_date.h"

#include <ctime>
#include <iomanip>
#include <locale>
#include <sstream>

namespace cairn {

std::optional<std::chrono::sys_seconds> ParseHttpDate(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::tm date{};
  stream >> std::get_time(&date, "%a, %d %b %Y %H:%M:%S GMT");
  if (!stream || stream.peek() != std::istringstream::traits_type::eof()) {
    return std::nullopt;
  }
  return std::chrono::sys_seconds(std::chrono::seconds(timegm(&date)));
}

}  // namespace cairn
