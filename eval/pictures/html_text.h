// Text in HTML and SVG.
#ifndef CAIRN_EVAL_PICTURES_HTML_TEXT_H_
#define CAIRN_EVAL_PICTURES_HTML_TEXT_H_

#include <string>
#include <string_view>

namespace cairn {

// Makes text from outside safe between tags and in attributes in double quotes.
std::string HtmlText(std::string_view text);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_HTML_TEXT_H_
