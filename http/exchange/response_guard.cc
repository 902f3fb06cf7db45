#include "http/exchange/response_guard.h"

#include <fmt/format.h>

#include <algorithm>

namespace cairn {
namespace {

constexpr std::string_view kProtocol = "HTTP/1.";

// Whether the status line announces that another response follows, e.g. "HTTP/1.1 100 Continue".
bool IsInterim(std::string_view status_line) {
  const size_t space = status_line.find(' ');
  return space != std::string_view::npos && status_line.substr(space + 1).starts_with('1');
}

}  // namespace

bool ResponseGuard::Take(std::string_view bytes) {
  size_t taken = 0;
  while (violation_.empty() && part_ != Part::kBody && taken < bytes.size()) {
    TakeHeadByte(bytes[taken++]);
  }
  body_bytes_ += bytes.size() - taken;
  if (violation_.empty() && body_bytes_ > max_body_bytes_) {
    violation_ = fmt::format("the body of the response is longer than {} bytes", max_body_bytes_);
  }
  return violation_.empty();
}

void ResponseGuard::TakeHeadByte(char byte) {
  if (++head_bytes_ > kMaxHead) {
    violation_ = fmt::format("the head of the response is longer than {} bytes", kMaxHead);
  } else if (byte == '\n') {
    EndLine();
  } else if (byte != '\r') {
    ++line_bytes_;
    if (part_ == Part::kStatusLine) {
      status_line_ += byte;
      const size_t common = std::min(status_line_.size(), kProtocol.size());
      if (std::string_view(status_line_).substr(0, common) != kProtocol.substr(0, common)) {
        violation_ = "the response is not HTTP";
      }
    }
    const size_t limit = part_ == Part::kStatusLine ? kMaxStatusLine : kMaxLine;
    if (line_bytes_ > limit) {
      violation_ = fmt::format("a line of the response's head is longer than {} bytes", limit);
    }
  }
}

void ResponseGuard::EndLine() {
  if (part_ == Part::kStatusLine) {
    if (status_line_.size() < kProtocol.size()) {
      violation_ = "the response is not HTTP";
    }
    part_ = Part::kHeaderLine;
  } else if (line_bytes_ == 0) {
    part_ = IsInterim(status_line_) ? Part::kStatusLine : Part::kBody;
    status_line_.clear();
  }
  line_bytes_ = 0;
}

}  // namespace cairn
