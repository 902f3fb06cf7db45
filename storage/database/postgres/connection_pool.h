// Keeps connections for reading, for reuse.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_CONNECTION_POOL_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_CONNECTION_POOL_H_

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "storage/database/postgres/server.h"

namespace cairn::postgres {

// A new connection takes milliseconds, so connections are kept with their compiled statements. Safe
// to call from any thread.
class ConnectionPool {
 public:
  static constexpr int kMaxConnections = 16;

  // `server` must outlive the pool. `silence` is the longest time without a byte from the server.
  ConnectionPool(const Server* server, std::chrono::milliseconds silence)
      : server_(server), silence_(silence) {}

  // Borrows a connection. Each wait on the connection ends at the deadline, or after the longest
  // silence. If kMaxConnections are borrowed, waits until one is returned.
  // Throws Error(kUnavailable) if none is returned in time, and what Server::Connect throws.
  std::unique_ptr<PostgresConnection> Take(db::Deadline deadline);
  // Returns a connection. If it is no longer usable, closes it and the idle connections, which are
  // probably dead as well.
  void GiveBack(std::unique_ptr<PostgresConnection> connection);

 private:
  std::unique_ptr<PostgresConnection> TakeIdle(db::Deadline deadline);

  const Server* server_;
  const std::chrono::milliseconds silence_;
  std::mutex mutex_;  // Guards the members below.
  std::condition_variable given_back_;
  std::vector<std::unique_ptr<PostgresConnection>> idle_;
  int num_borrowed_ = 0;
};

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_CONNECTION_POOL_H_
