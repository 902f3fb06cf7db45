#include "http/wire/multipart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "http/wire/problem.h"

namespace cairn {
namespace {

// The boundary of all bodies written here.
constexpr char kBoundary[] = "cairn-client-5f1c2a9e7d304b68";

constexpr size_t kMaxParts = 16;
constexpr size_t kMaxPartHeadBytes = 4096;
constexpr size_t kMaxBoundaryLength = 70;  // RFC 2046.

[[noreturn]] void RefuseBody(const std::string& detail) {
  throw HttpError(ProblemCode::kInvalidMultipart, "multipart body: " + detail)
      .Hint(
          "send the parts 'request' (JSON) and 'image' or 'features'; curl -F writes such a body");
}

bool EqualsIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

std::string_view Trim(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// The part's name from its Content-Disposition.
std::string_view PartName(std::string_view head) {
  while (!head.empty()) {
    const size_t end = head.find("\r\n");
    const std::string_view line = head.substr(0, end);
    head = end == std::string_view::npos ? "" : head.substr(end + 2);
    const size_t colon = line.find(':');
    if (colon != std::string_view::npos &&
        EqualsIgnoringCase(line.substr(0, colon), "content-disposition")) {
      return HeaderParameter(line.substr(colon + 1), "name");
    }
  }
  return {};
}

// Splits a part's bytes into head and content.
MultipartPart ParsePart(std::string_view part) {
  const bool no_headers = part.starts_with("\r\n");
  const size_t head_end = no_headers ? 0 : part.substr(0, kMaxPartHeadBytes).find("\r\n\r\n");
  if (head_end == std::string_view::npos) {
    RefuseBody("the headers of a part have no end");
  }
  const std::string_view name = PartName(part.substr(0, head_end));
  if (name.empty()) {
    RefuseBody("a part has no name in its Content-Disposition");
  }
  return {.name = name, .content = part.substr(head_end + 4)};
}

}  // namespace

std::string MediaType(std::string_view content_type) {
  std::string type(Trim(content_type.substr(0, content_type.find(';'))));
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return type;
}

std::string_view HeaderParameter(std::string_view header_value, std::string_view parameter) {
  size_t separator = header_value.find(';');
  while (separator != std::string_view::npos) {
    header_value.remove_prefix(separator + 1);
    // A quoted value may contain the separator.
    const size_t equals = header_value.find('=');
    const size_t next = header_value.find(';');
    if (equals == std::string_view::npos) {
      return {};
    }
    if (next < equals) {
      separator = next;
      continue;
    }
    const std::string_view key = Trim(header_value.substr(0, equals));
    std::string_view value = header_value.substr(equals + 1);
    if (value.starts_with('"')) {
      const size_t quote = value.find('"', 1);
      if (quote == std::string_view::npos) {
        return {};
      }
      separator = header_value.find(';', equals + 1 + quote);
      value = value.substr(1, quote - 1);
    } else {
      separator = next;
      value = Trim(value.substr(0, value.find(';')));
    }
    if (EqualsIgnoringCase(key, parameter)) {
      return value;
    }
  }
  return {};
}

bool IsMultipart(std::string_view content_type) {
  return MediaType(content_type) == "multipart/form-data";
}

std::vector<MultipartPart> ParseMultipart(std::string_view content_type, std::string_view body) {
  const std::string_view boundary = HeaderParameter(content_type, "boundary");
  if (boundary.empty() || boundary.size() > kMaxBoundaryLength) {
    RefuseBody("the Content-Type has no usable boundary");
  }
  const std::string first = fmt::format("--{}", boundary);
  const std::string delimiter = fmt::format("\r\n--{}", boundary);
  if (!body.starts_with(first)) {
    RefuseBody("the body does not start with the boundary");
  }
  body.remove_prefix(first.size());
  std::vector<MultipartPart> parts;
  while (!body.starts_with("--")) {
    if (!body.starts_with("\r\n")) {
      RefuseBody("a boundary is not followed by a line break");
    }
    body.remove_prefix(2);
    const size_t end = body.find(delimiter);
    if (end == std::string_view::npos) {
      RefuseBody("the closing boundary is missing");
    }
    if (parts.size() == kMaxParts) {
      RefuseBody(fmt::format("more than {} parts", kMaxParts));
    }
    const MultipartPart part = ParsePart(body.substr(0, end));
    for (const MultipartPart& other : parts) {
      if (other.name == part.name) {
        RefuseBody(fmt::format("two parts are named '{}'", part.name.substr(0, 64)));
      }
    }
    parts.push_back(part);
    body.remove_prefix(end + delimiter.size());
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
