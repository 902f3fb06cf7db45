// A thread that watches the latest version of a map in PostgreSQL.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_HEAD_WATCHER_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_HEAD_WATCHER_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "storage/database/postgres/server.h"

namespace cairn::postgres {

// On a primary, the thread waits for notifications (LISTEN cairn_head) and also asks once a second.
// A standby sends no notifications, so the thread asks four times a second. A server that does not
// answer within half a second is silent. The thread then tries again five times a second.
class HeadWatcher {
 public:
  struct Head {
    int64_t version = 0;
    // How often the latest version has become lower. A standby that lacked the newest versions has
    // then become the primary, and later versions may have other content than those of the same
    // number before.
    int num_losses = 0;
    bool is_silent = false;  // The last question failed, or two seconds passed without an answer.
  };

  // `server` must outlive the watcher. `version` is the latest version as of now.
  HeadWatcher(const Server* server, int64_t version);

  Head head() const;  // Safe to call from any thread.

 private:
  void Work(const std::stop_token& stop);
  // Watches over one connection until the connection fails or the thread must end.
  void Watch(const std::stop_token& stop);
  void Set(int64_t version);

  const Server* server_;
  mutable std::mutex mutex_;  // Guards the next two members.
  Head head_;
  std::chrono::steady_clock::time_point last_answer_;
  // The last member, so that the thread ends before the other members are destroyed.
  std::jthread thread_;
};

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_HEAD_WATCHER_H_
