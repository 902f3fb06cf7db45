#include "core/wire/multipart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>
#include <utility>

#include "core/wire/problem.h"

namespace cairn {
namespace {

constexpr char kHintOnParts[] =
    "send the parts 'request' (JSON) and 'image' or 'features'; curl -F writes such a body";
// Programs that set the Content-Type themselves do not know the boundary that their library chose.
constexpr char kHintOnBoundary[] =
    "let the HTTP library set the Content-Type, with the boundary that it chose; do not set it by "
    "hand";

// The boundary of all bodies written here.
constexpr char kBoundary[] = "cairn-client-5f1c2a9e7d304b68";

constexpr size_t kMaxParts = 16;
constexpr size_t kMaxPartHeadBytes = 4096;
constexpr size_t kMaxBoundaryLength = 70;  // RFC 2046.

[[noreturn]] void RefuseBody(const std::string& detail, const char* hint = kHintOnParts) {
  throw HttpError(ProblemCode::kInvalidMultipart, "multipart body: " + detail).Hint(hint);
}

bool EqualsIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

std::string_view Trim(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

// Removes and returns the first header of `head`, with its continuation lines.
std::string_view TakeHeader(std::string_view line_break, std::string_view* head) {
  size_t end = head->find(line_break);
  while (end != std::string_view::npos) {
    const std::string_view next = head->substr(end + line_break.size());
    if (!next.starts_with(' ') && !next.starts_with('\t')) {
      break;
    }
    end = head->find(line_break, end + line_break.size());
  }
  const std::string_view header = head->substr(0, end);
  *head = end == std::string_view::npos ? "" : head->substr(end + line_break.size());
  return header;
}

// The value of a part's header; empty if the header is missing.
std::string_view PartHeader(std::string_view head, std::string_view line_break,
                            std::string_view name) {
  while (!head.empty()) {
    const std::string_view header = TakeHeader(line_break, &head);
    const size_t colon = header.find(':');
    if (colon != std::string_view::npos &&
        EqualsIgnoringCase(Trim(header.substr(0, colon)), name)) {
      return Trim(header.substr(colon + 1));
    }
  }
  return {};
}

// A line that separates two parts, or ends the last one.
struct BoundaryLine {
  size_t begin;                 // Of its two dashes.
  size_t end;                   // Behind its line break.
  bool is_last;                 // The closing boundary, or a boundary at the end of the body.
  std::string_view line_break;  // Empty if `is_last`.
};

// The dashes, the boundary, and what RFC 2046 allows behind them: blanks, and then a line break or
// two dashes. Returns nothing if the text at `begin` only begins like that.
std::optional<BoundaryLine> BoundaryLineAt(std::string_view body, size_t begin, size_t num_bytes) {
  std::string_view rest = body.substr(begin + num_bytes);
  if (rest.starts_with("--")) {
    return BoundaryLine{.begin = begin, .end = body.size(), .is_last = true, .line_break = {}};
  }
  while (!rest.empty() && (rest.front() == ' ' || rest.front() == '\t')) {
    rest.remove_prefix(1);
  }
  for (const std::string_view line_break : {"\r\n", "\n"}) {
    if (rest.starts_with(line_break)) {
      const size_t end = body.size() - rest.size() + line_break.size();
      return BoundaryLine{
          .begin = begin, .end = end, .is_last = end == body.size(), .line_break = line_break};
    }
  }
  if (rest.empty()) {
    return BoundaryLine{.begin = begin, .end = body.size(), .is_last = true, .line_break = {}};
  }
  return std::nullopt;
}

bool BeginsLineOfDashes(const char* text) {
  return text[0] == '\n' && text[1] == '-' && text[2] == '-';
}

// True if a line that begins within `text` begins with two dashes.
bool HasLineOfDashes(std::string_view text) {
  bool is_here = false;
  for (size_t i = 0; i + 2 < text.size(); ++i) {
    is_here |= BeginsLineOfDashes(text.data() + i);  // Without a branch, many at once.
  }
  return is_here;
}

// Finds the next boundary at or behind `from` that begins a line, where lines end with
// `line_break`. A body is split before its request waits for its turn, so this looks at blocks: a
// search for the boundary would stop at every dash of a body that is nothing but dashes.
std::optional<BoundaryLine> FindBoundaryLine(std::string_view body, size_t from,
                                             std::string_view dashed_boundary,
                                             std::string_view line_break) {
  constexpr size_t kBlock = 64;
  const auto boundary_at = [&](size_t begin) {
    const bool is_here = body.substr(begin).starts_with(dashed_boundary) &&
                         (begin == 0 || body.substr(0, begin).ends_with(line_break));
    return is_here ? BoundaryLineAt(body, begin, dashed_boundary.size()) : std::nullopt;
  };
  if (from == 0) {
    if (const auto line = boundary_at(0)) {
      return line;
    }
  }
  for (size_t block = std::max<size_t>(from, 1) - 1; block < body.size(); block += kBlock) {
    if (!HasLineOfDashes(body.substr(block, kBlock + 2))) {
      continue;
    }
    for (size_t at = block; at < block + kBlock && at + 2 < body.size(); ++at) {
      if (!BeginsLineOfDashes(body.data() + at)) {
        continue;
      }
      if (const auto line = boundary_at(at + 1)) {
        return line;
      }
    }
  }
  return std::nullopt;
}

// Splits a part's bytes into head and content.
MultipartPart ParsePart(std::string_view part, std::string_view line_break) {
  const bool no_headers = part.starts_with(line_break);
  const std::string empty_line = fmt::format("{}{}", line_break, line_break);
  const size_t head_end = no_headers ? 0 : part.substr(0, kMaxPartHeadBytes).find(empty_line);
  if (head_end == std::string_view::npos) {
    RefuseBody("the headers of a part have no end");
  }
  const std::string_view head = part.substr(0, head_end);
  const std::string_view name =
      HeaderParameter(PartHeader(head, line_break, "content-disposition"), "name");
  if (name.empty()) {
    RefuseBody("a part has no name in its Content-Disposition");
  }
  const std::string_view encoding = PartHeader(head, line_break, "content-transfer-encoding");
  return {.name = name,
          .content = part.substr(head_end + empty_line.size()),
          .is_base64 = EqualsIgnoringCase(encoding, "base64")};
}

void AddPart(const MultipartPart& part, std::vector<MultipartPart>* parts) {
  if (parts->size() == kMaxParts) {
    RefuseBody(fmt::format("more than {} parts", kMaxParts));
  }
  for (const MultipartPart& other : *parts) {
    if (other.name == part.name) {
      RefuseBody(fmt::format("two parts are named '{}'", part.name.substr(0, 64)));
    }
  }
  parts->push_back(part);
}

// The end of the quoted string that `text` begins with: the position of its closing quote. A
// backslash takes the meaning from the character behind it (RFC 9110 section 5.6.4).
size_t ClosingQuote(std::string_view text) {
  for (size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '\\') {
      ++i;
    } else if (text[i] == '"') {
      return i;
    }
  }
  return std::string_view::npos;
}

}  // namespace

std::string MediaType(std::string_view content_type) {
  std::string type(Trim(content_type.substr(0, content_type.find(';'))));
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return type;
}

std::string_view HeaderParameter(std::string_view header_value, std::string_view parameter) {
  std::string_view rest = header_value;
  size_t separator = rest.find(';');
  while (separator != std::string_view::npos) {
    rest.remove_prefix(separator + 1);
    const size_t equals = rest.find('=');
    separator = rest.find(';');
    if (equals == std::string_view::npos) {
      return {};
    }
    if (separator < equals) {
      continue;  // A parameter without a value.
    }
    const std::string_view key = Trim(rest.substr(0, equals));
    rest.remove_prefix(equals + 1);
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n"), rest.size()));
    std::string_view value;
    if (rest.starts_with('"')) {
      const size_t quote = ClosingQuote(rest);
      if (quote == std::string_view::npos) {
        return {};
      }
      value = rest.substr(1, quote - 1);
      rest.remove_prefix(quote + 1);
    } else {
      value = Trim(rest.substr(0, rest.find(';')));
    }
    if (EqualsIgnoringCase(key, parameter)) {
      return value;
    }
    separator = rest.find(';');
  }
  return {};
}

bool IsMultipart(std::string_view content_type) {
  return MediaType(content_type) == "multipart/form-data";
}

std::vector<MultipartPart> ParseMultipart(std::string_view content_type, std::string_view body) {
  const std::string_view boundary = HeaderParameter(content_type, "boundary");
  if (boundary.empty() || boundary.size() > kMaxBoundaryLength) {
    RefuseBody("the Content-Type has no usable boundary", kHintOnBoundary);
  }
  const std::string dashed_boundary = fmt::format("--{}", boundary);
  // Any text may stand before the first boundary (RFC 2046 section 5.1.1).
  std::optional<BoundaryLine> line = FindBoundaryLine(body, 0, dashed_boundary, "\n");
  if (!line) {
    RefuseBody("the body does not contain the boundary of the Content-Type", kHintOnBoundary);
  }
  const std::string_view line_break = line->line_break;  // That of the whole body.
  std::vector<MultipartPart> parts;
  while (line && !line->is_last) {
    const size_t begin = line->end;
    line = FindBoundaryLine(body, begin, dashed_boundary, line_break);
    // Unity writes no closing boundary. The Content-Length says that the body is whole.
    const size_t end = line ? std::max(begin, line->begin - line_break.size()) : body.size();
    AddPart(ParsePart(body.substr(begin, end - begin), line_break), &parts);
  }
  if (parts.empty()) {
    RefuseBody("there are no parts");
  }
  return parts;
}

std::string MultipartWriter::ContentType() {
  return fmt::format("multipart/form-data; boundary={}", kBoundary);
}

void MultipartWriter::Add(std::string_view name, std::string_view content_type,
                          std::string_view bytes) {
  body_.reserve(body_.size() + bytes.size() + 512);
  body_ += fmt::format(
      "--{}\r\nContent-Disposition: form-data; name=\"{}\"; filename=\"{}\"\r\n"
      "Content-Type: {}\r\n\r\n",
      kBoundary, name, name, content_type);
  body_.append(bytes);
  body_ += "\r\n";
}

std::string MultipartWriter::Finish() && {
  body_ += fmt::format("--{}--\r\n", kBoundary);
  return std::move(body_);
}

}  // namespace cairn
