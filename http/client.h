// A synchronous client for the server's own API: `cairn localize --server`, `cairn eval --server`.
#ifndef CAIRN_HTTP_CLIENT_H_
#define CAIRN_HTTP_CLIENT_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/wire/wire_request.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"

namespace cairn {

struct ClientOptions {
  std::string url;           // As BoundedClientOptions::url.
  std::string ca_file = {};  // PEM file of the certificates to trust; empty: those of the system.
  std::string api_key = {};  // As BoundedClientOptions::api_key.
  bool allow_plain_key = false;  // As BoundedClientOptions::allow_plain_key.
  int timeout_ms = 30'000;       // For each exchange.
  bool want_matches = true;
  ImageOrientation image_orientation = ImageOrientation::kAsSize;  // Used by LocalizeImages.
  // Waits before a request is repeated. For tests; the default is std::this_thread::sleep_for.
  std::function<void(std::chrono::seconds)> wait = {};
  bool exif_prior = true;  // Without a prior, the server takes the position in the image's EXIF.
};

// Thrown if the server answers with another status than 200.
class ServerRefusal : public Error {
 public:
  ServerRefusal(ErrorCode code, const std::string& message, int status)
      : Error(code, message), status_(status) {}
  int status() const { return status_; }  // Of HTTP.

 private:
  int status_;
};

// Use a client from one thread only, apart from Stop. The client keeps its connection alive.
class LocalizeClient {
 public:
  // Throws Error(kInvalidArgument) if the URL has another scheme or the key may not go there, and
  // Error(kIo) if the file of certificates cannot be read.
  explicit LocalizeClient(const ClientOptions& options);
  ~LocalizeClient();

  // Send one query. LocalizeImages sends encoded images: first the image of the query's camera,
  // then the images of the other cameras of its rig, in order; it ignores the features of `query`.
  // LocalizeFeatures sends the query's features. If the distortion of a camera is unknown too, the
  // client sends only the camera's size. The result has the fields that the wire carries: pose,
  // position, covariance, confidence, tiles, counters, times, matches. Both throw
  // Error(kUnavailable) if no server answers, and Error(kBadInput) with the server's explanation if
  // the server refuses the request. If the key has used up its rate, they wait as long as the
  // server says, within the timeout; after that, and if the key has used up its quota, they throw
  // Error(kUnavailable).
  LocalizeResult LocalizeImages(const LocalizeQuery& query,
                                const std::vector<std::vector<uint8_t>>& images);
  LocalizeResult LocalizeFeatures(const LocalizeQuery& query);

  // Returns the body of a GET, for scripts and tests. Throws as above.
  std::string Get(const std::string& path);

  // Aborts the exchange under way, which throws Error(kUnavailable); see BoundedClient::Stop.
  void Stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_CLIENT_H_
