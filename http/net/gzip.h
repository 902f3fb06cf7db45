// Compression of response bodies.
#ifndef CAIRN_HTTP_NET_GZIP_H_
#define CAIRN_HTTP_NET_GZIP_H_

#include <string>
#include <string_view>

namespace cairn {

// True if an Accept-Encoding (RFC 9110 section 12.5.3) allows gzip.
bool AcceptsGzip(std::string_view accept_encoding);

enum class GzipEffort {
  // For one response: a list of tiles shrinks to a tenth, and the next levels take several times as
  // long for a few percent.
  kLeast,
  kMost,  // For what is compressed once and sent often.
};

// Returns the bytes in the format of gzip (RFC 1952).
std::string Gzip(std::string_view bytes, GzipEffort effort = GzipEffort::kLeast);

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_GZIP_H_
