// Watches the bytes of a response before the HTTP library sees them.
#ifndef CAIRN_HTTP_EXCHANGE_RESPONSE_GUARD_H_
#define CAIRN_HTTP_EXCHANGE_RESPONSE_GUARD_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace cairn {

// cpp-httplib matches the status line with std::regex, which recurses once a byte, and bounds
// neither the head nor the body of a response. It also reads lengths as strtoull does, takes the
// first of two, and skips lines that it does not understand. The guard therefore lets only
// responses pass whose end is the same for every reader (RFC 9112 section 6.3), so that a server or
// a front cannot make one response look like two. Not thread-safe; one object for one exchange.
class ResponseGuard {
 public:
  // Longest status line, longest other line, and all heads together (a server may send several
  // interim responses first), in bytes.
  static constexpr size_t kMaxStatusLine = 1024, kMaxLine = 8192, kMaxHead = size_t{32} << 10;

  // `max_body_bytes` bounds the body as it is sent, framing of chunks included.
  explicit ResponseGuard(size_t max_body_bytes) : max_body_bytes_(max_body_bytes) {}

  // Takes the next bytes from the server. Returns false, now and for all later bytes, if they do
  // not begin as an HTTP/1 response, exceed a limit, do not say clearly where the response ends
  // (two lengths, a length that is no number, another Transfer-Encoding than "chunked", chunks
  // without a size, folded lines, control characters), or go on behind that end. Linear in the
  // number of bytes.
  bool Take(std::string_view bytes);

  // Says what is wrong with the response; empty before.
  const std::string& violation() const { return violation_; }

 private:
  enum class Part { kStatusLine, kHeader, kChunkSize, kChunkEnd, kTrailer, kEnd };

  bool IsInHead() const { return part_ == Part::kStatusLine || part_ == Part::kHeader; }
  void TakeLineByte(char byte);
  void CountHeadByte();
  void CountBody(size_t num_bytes);
  void EndLine(std::string_view line);
  void TakeStatusLine(std::string_view line);
  void TakeHeader(std::string_view line);
  void TakeLength(std::string_view value);
  void TakeChunkSize(std::string_view line);
  void EndHead();

  size_t max_body_bytes_;
  Part part_ = Part::kStatusLine;
  std::string line_;           // The current line, as far as it has come.
  uint64_t payload_left_ = 0;  // Bytes of the body that come before part_ goes on.
  size_t head_bytes_ = 0;
  size_t body_bytes_ = 0;
  std::string status_;
  std::optional<uint64_t> length_;
  bool is_chunked_ = false;
  std::string violation_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_EXCHANGE_RESPONSE_GUARD_H_
