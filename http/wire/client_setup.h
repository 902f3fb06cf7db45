// How the clients of a server use the HTTP library.
#ifndef CAIRN_HTTP_WIRE_CLIENT_SETUP_H_
#define CAIRN_HTTP_WIRE_CLIENT_SETUP_H_

#include <ctime>

namespace cairn {

// One connection for all requests; `timeout_ms` each to connect, for a read and for a write.
// `HttpClient` is httplib::Client, which is slow to compile.
template <typename HttpClient>
void SetUpClient(int timeout_ms, HttpClient* client) {
  client->set_keep_alive(true);
  client->set_tcp_nodelay(true);
  const time_t seconds = timeout_ms / 1000;
  const time_t microseconds = timeout_ms % 1000 * 1000;
  client->set_connection_timeout(seconds, microseconds);
  client->set_read_timeout(seconds, microseconds);
  client->set_write_timeout(seconds, microseconds);
}

}  // namespace cairn

#endif  // CAIRN_HTTP_WIRE_CLIENT_SETUP_H_
