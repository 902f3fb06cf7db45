// The REST server.
#ifndef CAIRN_HTTP_SERVER_H_
#define CAIRN_HTTP_SERVER_H_

#include <cstdint>
#include <memory>

#include "http/service/server_options.h"

namespace cairn {

// Opens the map and serves it. Call Start and Stop from the same thread.
class Server {
 public:
  // Throws as MapStore::Open, ReadKeyFile and AccessLog. Throws Error(kConflict) if a port is
  // taken.
  explicit Server(const ServerOptions& options);
  ~Server();  // Stops.

  // Binds the ports and returns. Background threads then answer requests.
  void Start();
  // From now on /readyz answers 503, so that a front sends its queries to other servers. Queries
  // that come nevertheless are answered, and their connections closed. Follow with Stop.
  void Drain();
  // Lets running requests finish, but decodes no more images. Returns when all threads have ended.
  // Idempotent.
  void Stop();

  uint64_t num_requests() const;  // Answered so far, including refused ones.

  // Opens the file at map_path again. Requests that are running keep the map that they started
  // with. If the file holds another map, new requests use the new map. If there is no map, the old
  // map stays in use and /healthz reports the problem. Between Start and Stop, the server finds a
  // new map within about two seconds without this call.
  void ReloadMap();

  // Reads the file of API keys again. If it cannot be read, logs why and keeps the keys. Does
  // nothing without such a file.
  void ReloadKeys();

  // Opens the access log again, because somebody has moved the file. Does nothing without one.
  void ReopenAccessLog();

  int port() const;  // The ports bound; valid after Start.
  int admin_port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVER_H_
