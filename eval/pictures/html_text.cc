#include "eval/pictures/html_text.h"

#include "core/printable.h"

namespace cairn {

std::string HtmlText(std::string_view text) {
  std::string safe;
  for (const char letter : Printable(text)) {
    switch (letter) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += letter;
    }
  }
  return safe;
}

}  // namespace cairn
