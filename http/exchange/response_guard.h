// Watches the bytes of a response before the HTTP library sees them.
#ifndef CAIRN_HTTP_EXCHANGE_RESPONSE_GUARD_H_
#define CAIRN_HTTP_EXCHANGE_RESPONSE_GUARD_H_

#include <cstddef>
#include <string>
#include <string_view>

namespace cairn {

// cpp-httplib matches the status line with std::regex, which recurses once a byte, and bounds
// neither the head nor the body of a response. Not thread-safe; one object for one exchange.
class ResponseGuard {
 public:
  // Longest status line, longest line of the head, and all heads together (a server may send
  // several interim responses first), in bytes.
  static constexpr size_t kMaxStatusLine = 1024, kMaxLine = 8192, kMaxHead = size_t{32} << 10;

  // `max_body_bytes` bounds the body as it is sent, framing of chunks included.
  explicit ResponseGuard(size_t max_body_bytes) : max_body_bytes_(max_body_bytes) {}

  // Takes the next bytes from the server. Returns false, now and for all later bytes, if they do
  // not begin as an HTTP/1 response or exceed a limit. Linear in the number of bytes.
  bool Take(std::string_view bytes);

  // Says which limit was exceeded; empty before.
  const std::string& violation() const { return violation_; }

 private:
  enum class Part { kStatusLine, kHeaderLine, kBody };

  void TakeHeadByte(char byte);
  void EndLine();

  size_t max_body_bytes_;
  Part part_ = Part::kStatusLine;
  std::string status_line_;
  size_t line_bytes_ = 0;  // Of the current line without its end.
  size_t head_bytes_ = 0;
  size_t body_bytes_ = 0;
  std::string violation_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_EXCHANGE_RESPONSE_GUARD_H_
