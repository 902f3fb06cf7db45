// The REST server.
#ifndef CAIRN_HTTP_SERVER_H_
#define CAIRN_HTTP_SERVER_H_

#include <cstdint>
#include <memory>

#include "http/service/server_options.h"

namespace cairn {

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
