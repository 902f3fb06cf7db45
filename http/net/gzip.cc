#include "http/net/gzip.h"

#include <zlib.h>

#include "core/error.h"
#include "core/wire/accept.h"
#include "core/wire/multipart.h"

namespace cairn {

bool AcceptsGzip(std::string_view accept_encoding) {
  while (!accept_encoding.empty()) {
    const std::string_view coding = TakeElement(&accept_encoding);
    if (MediaType(coding) == "gzip") {
      return Quality(coding) > 0.0;
    }
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
