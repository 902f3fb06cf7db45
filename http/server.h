// The REST server.
#ifndef CAIRN_HTTP_SERVER_H_
#define CAIRN_HTTP_SERVER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "engine/localizer_options.h"

namespace cairn {

struct ServerOptions {
  std::string map_path;
  std::string host = "127.0.0.1";
  int port = 8080;  // 0 picks a free one; see Server::port.
  std::string admin_host = "127.0.0.1";
  int admin_port = -1;  // Health and metrics apart; 0 picks a free one, -1: same listener.
  // Requests answered at once; 0 is 64, or twice the cores if that is more. No more queries are
  // computed at once than there are cores: the others wait in line. Open connections need no
  // thread.
  int num_threads = 0;
  // Threads that one query may use while cores are free; 0 is as many as there are cores. Counts
  // instead of localizer.num_threads.
  int threads_per_query = 0;
  size_t cache_bytes = size_t{1} << 30;
  // Holds a picture of max_image_pixels: as JPEG, and as GRAY8 in base64, which takes 16,000,000
  // bytes. RGBA32 of that size needs 64 MB.
  size_t max_body_bytes = size_t{16} << 20;
  int64_t max_image_pixels = 12'000'000;
  int max_features = 5000;
  int default_timeout_ms = 2000;
  LocalizerOptions localizer;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Opens the map and serves it. Start and Stop from one thread.
class Server {
 public:
  // Throws as MapStore::Open, and Error(kConflict) if a port is taken.
  explicit Server(const ServerOptions& options);
  ~Server();  // Stops.

  // Binds, then returns; requests are answered by background threads from then on.
  void Start();
  // Lets running requests finish, but decodes no more images; returns when all threads have ended.
  // Idempotent.
  void Stop();

  uint64_t num_requests() const;  // Answered so far, refusals among them.

  // Opens the file at map_path again; what runs is answered from the map it began with. If there is
  // another map, requests see it from now on; if there is none, /healthz says so and the old one
  // stays. Between Start and Stop a new file is found without it, within about a second, but not
  // one that was overwritten in place.
  void ReloadMap();

  int port() const;  // Bound ports, valid after Start.
  int admin_port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVER_H_
