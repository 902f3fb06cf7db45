// A synchronous client for the server's own API: `cairn localize --server`, `cairn eval --server`.
#ifndef CAIRN_HTTP_CLIENT_H_
#define CAIRN_HTTP_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"
#include "http/json/image_orientation.h"

namespace cairn {

struct ClientOptions {
  std::string url;          // "http://host:port".
  int timeout_ms = 30'000;  // Connect and read.
  bool want_matches = true;
  ImageOrientation image_orientation = ImageOrientation::kAsSize;  // Of LocalizeImages.
};

// One thread per client; it keeps its connection alive.
class LocalizeClient {
 public:
  // Throws Error(kInvalidArgument) if the URL makes no sense.
  explicit LocalizeClient(const ClientOptions& options);
  ~LocalizeClient();

  // Send one query, as encoded images of its camera and the others of its rig in this order (the
  // features of `query` are ignored) or as the query's features. Of a camera of which the
  // distortion is unknown, too, only the size is sent. The result has what the wire carries: pose,
  // position, covariance, confidence, tiles, counters, times, matches. Throws Error(kUnavailable)
  // if no server answers, Error(kBadInput) with the server's own explanation if it refuses the
  // request.
  LocalizeResult LocalizeImages(const LocalizeQuery& query,
                                const std::vector<std::vector<uint8_t>>& images);
  LocalizeResult LocalizeFeatures(const LocalizeQuery& query);

  // The body of a GET, for scripts and tests; throws as above.
  std::string Get(const std::string& path);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_CLIENT_H_
