// Options of the server.
#ifndef CAIRN_HTTP_SERVICE_SERVER_OPTIONS_H_
#define CAIRN_HTTP_SERVICE_SERVER_OPTIONS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/features/sift/sift_extractor.h"
#include "core/images/gray_image.h"
#include "core/wire/wire_request.h"
#include "engine/localizer_options.h"
#include "http/json/request_limits.h"

namespace cairn {

// The loopback: health and metrics are for monitoring on the same machine.
inline constexpr char kAdminHost[] = "127.0.0.1";

inline constexpr int kMaxDrainSeconds = 3600;

struct ServerOptions {
  std::string map_path;
  std::string host = "127.0.0.1";
  int port = 8080;  // 0 picks a free port; see Server::port.
  // Separate port of kAdminHost for health and metrics; 0 picks a free port, -1 uses `port`.
  int admin_port = -1;
  // Requests answered at once. 0 means 64, or four times the number of cores if that is more. At
  // most as many queries compute at once as there are cores; the others wait in line. Open
  // connections need no thread.
  int num_threads = 0;
  // Requests that wait for their turn at once. The others get 503; the client with most waiting
  // requests loses one first. 0 means at most three quarters of the threads, which leaves threads
  // to requests that need no turn.
  int max_waiting = 0;
  // Threads that one query may use while cores are free. 0 means the number of cores. Replaces
  // localizer.num_threads.
  int threads_per_query = 0;
  // Time after SIGTERM during which /readyz answers 503 and queries are still answered, so that a
  // front notices before the port closes. 0 stops at once.
  int drain_s = 0;
  // How long a connection may be silent between requests, seconds. Longer than fronts keep their
  // connections, so that no request meets a closing connection.
  int keep_alive_s = 75;
  size_t cache_bytes = size_t{1} << 30;
  // Fits a JPEG of 48 megapixels, which has 10 to 24 MB, or a picture of max_image_pixels as GRAY8
  // in base64, which takes 17 MB. RGBA32 of that size needs 67 MB in base64.
  size_t max_body_bytes = size_t{32} << 20;
  // Of a picture as it is decoded; see ImageDecodeLimits.
  int64_t max_image_pixels = ImageDecodeLimits().max_pixels;
  // Takes the position in a photo's EXIF as the prior of a request without one.
  bool exif_prior = true;
  int max_features = RequestLimits().max_features;
  int default_timeout_ms = RequestLimits().default_timeout_ms;
  // Longest time that a query gets, whatever its timeoutMs asks for.
  int max_timeout_ms = kMaxTimeoutMs;
  // The fronts that may name their clients in X-Forwarded-For: addresses and networks such as
  // "10.0.0.0/8", separated by commas. The requests of other clients count for their own address.
  std::string trusted_fronts;
  // File of the API keys that open the routes of the main port (docs/formats/api_keys_v1.md).
  // Nothing: everything is open. An empty path is refused, because it may be that of a variable
  // that is not set. The admin port needs no key, because only this machine reaches it.
  std::optional<std::string> api_keys_path;
  // File to which a line is appended for each request to the main port (service/access_log.h).
  // Empty: none.
  std::string access_log_path;
  LocalizerOptions localizer;
  SiftOptions sift;  // Of the images of requests.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// The number of threads that answer requests: num_threads, or its default.
int NumThreads(const ServerOptions& options);

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_SERVER_OPTIONS_H_
