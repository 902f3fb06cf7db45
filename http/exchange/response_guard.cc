#include "http/exchange/response_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "core/wire/header_line.h"

namespace cairn {
namespace {

constexpr std::string_view kProtocol = "HTTP/1.";
constexpr size_t kStatusDigits = 3;

// Reads a number that has nothing but digits. Returns nothing if it is too large, too.
std::optional<uint64_t> ParseDigits(std::string_view text, int base) {
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) {
    return std::nullopt;
  }
  return number;
}

}  // namespace

bool ResponseGuard::Take(std::string_view bytes) {
  while (violation_.empty() && !bytes.empty()) {
    const auto num_payload = static_cast<size_t>(std::min<uint64_t>(payload_left_, bytes.size()));
    if (num_payload == 0) {
      TakeLineByte(bytes.front());
      bytes.remove_prefix(1);
    } else {
      payload_left_ -= num_payload;
      CountBody(num_payload);
      bytes.remove_prefix(num_payload);
    }
  }
  return violation_.empty();
}

void ResponseGuard::CountHeadByte() {
  if (++head_bytes_ > kMaxHead) {
    violation_ = fmt::format("the head of the response is longer than {} bytes", kMaxHead);
  }
}

void ResponseGuard::CountBody(size_t num_bytes) {
  body_bytes_ += num_bytes;
  if (body_bytes_ > max_body_bytes_) {
    violation_ = fmt::format("the body of the response is longer than {} bytes", max_body_bytes_);
  }
}

void ResponseGuard::TakeLineByte(char byte) {
  if (part_ == Part::kEnd) {
    violation_ = "bytes follow the end of the response";
    return;
  }
  if (IsInHead()) {
    CountHeadByte();
  } else {
    CountBody(1);
  }
  line_ += byte;
  const size_t limit = part_ == Part::kStatusLine ? kMaxStatusLine : kMaxLine;
  if (!violation_.empty()) {
    return;
  }
  if (part_ == Part::kStatusLine && line_.size() <= kProtocol.size() &&
      line_ != kProtocol.substr(0, line_.size())) {
    violation_ = "the response is not HTTP";
  } else if (line_.size() > limit) {
    violation_ = fmt::format("a line of the response is longer than {} bytes", limit);
  } else if (line_.ends_with("\r\n")) {
    EndLine(std::string_view(line_).substr(0, line_.size() - 2));
    line_.clear();
  } else if (byte == '\n') {
    violation_ = "a line of the response ends without a carriage return";
  }
}

void ResponseGuard::EndLine(std::string_view line) {
  switch (part_) {
    case Part::kStatusLine:
      return TakeStatusLine(line);
    case Part::kHeader:
      return line.empty() ? EndHead() : TakeHeader(line);
    case Part::kChunkSize:
      return TakeChunkSize(line);
    case Part::kChunkEnd:
      if (!line.empty()) {
        violation_ = "a chunk of the response is longer than its size";
      }
      part_ = Part::kChunkSize;
      return;
    case Part::kTrailer:
      if (line.empty()) {
        part_ = Part::kEnd;
      } else if (!SplitHeaderLine(line)) {
        violation_ = "a line behind the last chunk of the response is not 'Name: value'";
      }
      return;
    case Part::kEnd:
      return;  // Has no lines.
  }
}

// "HTTP/1.1 200 OK"; the reason may be missing.
void ResponseGuard::TakeStatusLine(std::string_view line) {
  const std::string_view rest = line.substr(kProtocol.size());
  const bool is_version = rest.starts_with("0 ") || rest.starts_with("1 ");
  const std::string_view status = is_version ? rest.substr(2, kStatusDigits) : "";
  const std::string_view reason = is_version ? rest.substr(2 + status.size()) : "";
  if (status.size() != kStatusDigits || !ParseDigits(status, 10) || !IsHeaderText(reason) ||
      !(reason.empty() || reason.starts_with(' '))) {
    violation_ = "the response is not HTTP/1.0 or HTTP/1.1";
  } else if (status.starts_with('1') && status != "100") {
    // The library takes it for the response.
    violation_ = fmt::format("the response has the interim status {}", status);
  }
  status_ = status;
  part_ = Part::kHeader;
}

void ResponseGuard::TakeHeader(std::string_view line) {
  const std::optional<HeaderLine> header = SplitHeaderLine(line);
  if (!header) {
    violation_ = "a line of the response's head is not 'Name: value', or has a control character";
  } else if (header->name == "content-length") {
    TakeLength(header->value);
  } else if (header->name == "transfer-encoding") {
    if (is_chunked_ || ToLowerAscii(header->value) != "chunked") {
      violation_ = "the response has another Transfer-Encoding than 'chunked'";
    }
    is_chunked_ = true;
  }
  if (length_ && is_chunked_ && violation_.empty()) {
    violation_ = "the response has both Content-Length and Transfer-Encoding";
  }
}

void ResponseGuard::TakeLength(std::string_view value) {
  const std::optional<uint64_t> length = ParseDigits(value, 10);
  if (!length) {
    violation_ = "the Content-Length of the response is not a number";
  } else if (length_ && *length_ != *length) {
    violation_ = "the response has two different Content-Lengths";
  }
  length_ = length;
}

void ResponseGuard::EndHead() {
  if (status_ == "100") {
    part_ = Part::kStatusLine;
    length_.reset();
    is_chunked_ = false;
  } else if (status_ == "204" || status_ == "304") {
    part_ = Part::kEnd;
  } else if (is_chunked_) {
    part_ = Part::kChunkSize;
  } else {
    part_ = Part::kEnd;
    // A response without a length ends with the connection.
    payload_left_ = length_.value_or(std::numeric_limits<uint64_t>::max());
  }
}

// "1f", or "1f;name=value"; some servers write blanks behind the size.
void ResponseGuard::TakeChunkSize(std::string_view line) {
  const std::string_view digits = line.substr(0, line.find_first_of(" \t;"));
  const std::string_view rest = line.substr(digits.size());
  const size_t extension = std::min(rest.find_first_not_of(" \t"), rest.size());
  const std::optional<uint64_t> size = ParseDigits(digits, 16);
  if (!size || !IsHeaderText(rest) || (extension < rest.size() && rest[extension] != ';')) {
    violation_ = "a chunk of the response has no size";
    return;
  }
  payload_left_ = *size;
  part_ = *size == 0 ? Part::kTrailer : Part::kChunkEnd;
}

}  // namespace cairn
