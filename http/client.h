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
  std::string url;           // "http://host:port" or "https://host:port".
  std::string ca_file = {};  // PEM file of the certificates to trust; empty: those of the system.
  int timeout_ms = 30'000;   // For each exchange.
  bool want_matches = true;
  ImageOrientation image_orientation = ImageOrientation::kAsSize;  // Used by LocalizeImages.
  bool exif_prior = true;  // Without a prior, the server takes the position in the image's EXIF.
};

// Use a client from one thread only. The client keeps its connection alive.
class LocalizeClient {
 public:
  // Throws Error(kInvalidArgument) if the URL is none of the two, and Error(kIo) if the file of
  // certificates cannot be read.
  explicit LocalizeClient(const ClientOptions& options);
  ~LocalizeClient();

  // Send one query. LocalizeImages sends encoded images: first the image of the query's camera,
  // then the images of the other cameras of its rig, in order; it ignores the features of `query`.
  // LocalizeFeatures sends the query's features. If the distortion of a camera is unknown too, the
  // client sends only the camera's size. The result has the fields that the wire carries: pose,
  // position, covariance, confidence, tiles, counters, times, matches. Both throw
  // Error(kUnavailable) if no server answers, and Error(kBadInput) with the server's explanation if
  // the server refuses the request.
  LocalizeResult LocalizeImages(const LocalizeQuery& query,
                                const std::vector<std::vector<uint8_t>>& images);
  LocalizeResult LocalizeFeatures(const LocalizeQuery& query);

  // Returns the body of a GET, for scripts and tests. Throws as above.
  std::string Get(const std::string& path);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_CLIENT_H_
