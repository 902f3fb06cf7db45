#include "http/net/gzip.h"

#include <zlib.h>

#include <charconv>

#include "core/error.h"
#include "core/wire/multipart.h"

namespace cairn {
namespace {

// The weight of a coding; 1 without one.
double Quality(std::string_view coding) {
  const std::string_view text = HeaderParameter(coding, "q");
  double quality = 1.0;
  std::from_chars(text.data(), text.data() + text.size(), quality);
  return quality;
}

}  // namespace

bool AcceptsGzip(std::string_view accept_encoding) {
  while (!accept_encoding.empty()) {
    const size_t comma = accept_encoding.find(',');
    const std::string_view coding = accept_encoding.substr(0, comma);
    if (MediaType(coding) == "gzip") {
      return Quality(coding) > 0.0;
    }
    accept_encoding = comma == std::string_view::npos ? "" : accept_encoding.substr(comma + 1);
  }
  return false;
}

std::string Gzip(std::string_view bytes, GzipEffort effort) {
  constexpr int kGzipWindow = 15 + 16;  // The largest window; 16 asks for the format of gzip.
  constexpr int kMemoryLevel = 8;       // The default.
  const int level = effort == GzipEffort::kMost ? Z_BEST_COMPRESSION : Z_BEST_SPEED;
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, kGzipWindow, kMemoryLevel, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw Error(ErrorCode::kInternal, "zlib cannot start");
  }
  std::string zipped(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(zipped.data());
  stream.avail_out = static_cast<uInt>(zipped.size());
  const int result = deflate(&stream, Z_FINISH);  // The bound makes one call suffice.
  zipped.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) {
    throw Error(ErrorCode::kInternal, "zlib cannot compress a response");
  }
  return zipped;
}

}  // namespace cairn
