#include "storage/database/postgres/head_watcher.h"

#include <algorithm>
#include <condition_variable>

#include "core/error.h"

namespace cairn::postgres {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kAnswerTime{500};
constexpr milliseconds kPause{200};
constexpr milliseconds kPollOfPrimary{1000};
constexpr milliseconds kPollOfStandby{250};
constexpr milliseconds kSliceOfWait{100};  // The longest time until the thread ends.
constexpr milliseconds kLongestSilence{2000};

bool IsStandby(PostgresConnection* connection) {
  db::Statement row = connection->Prepare("SELECT pg_is_in_recovery()");
  row.Step();
  return row.Int64(0) != 0;
}

int64_t LatestVersion(PostgresConnection* connection) {
  connection->link().set_patience({Clock::now() + kAnswerTime, kAnswerTime});
  db::Statement row = connection->Prepare("SELECT max(version) FROM cairn_versions");
  row.Step();
  return row.Int64(0);
}

void WaitForNews(PostgresConnection* connection, milliseconds longest,
                 const std::stop_token& stop) {
  const Clock::time_point end = Clock::now() + longest;
  while (!stop.stop_requested() && Clock::now() < end) {
    if (connection->link().WaitForNotification(std::min(end, Clock::now() + kSliceOfWait))) {
      return;
    }
  }
}

void Pause(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, kPause, [] { return false; });
}

}  // namespace

HeadWatcher::HeadWatcher(const Server* server, int64_t version)
    : server_(server),
      head_{.version = version},
      last_answer_(Clock::now()),
      thread_([this](const std::stop_token& stop) { Work(stop); }) {}

HeadWatcher::Head HeadWatcher::head() const {
  const std::lock_guard lock(mutex_);
  Head head = head_;
  head.is_silent = head.is_silent || Clock::now() - last_answer_ > kLongestSilence;
  return head;
}

void HeadWatcher::Set(int64_t version) {
  const std::lock_guard lock(mutex_);
  if (version < head_.version) {
    ++head_.num_losses;
  }
  head_.version = version;
  head_.is_silent = false;
  last_answer_ = Clock::now();
}

void HeadWatcher::Work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    try {
      Watch(stop);
    } catch (const std::exception&) {
      const std::lock_guard lock(mutex_);
      head_.is_silent = true;
    }
    Pause(stop);
  }
}

void HeadWatcher::Watch(const std::stop_token& stop) {
  const auto connection =
      server_->Connect(Use::kRead, {Clock::now() + 2 * kAnswerTime, kAnswerTime});
  const bool is_standby = IsStandby(connection.get());
  if (!is_standby) {
    connection->Execute("LISTEN cairn_head");
  }
  while (!stop.stop_requested()) {
    Set(LatestVersion(connection.get()));
    WaitForNews(connection.get(), is_standby ? kPollOfStandby : kPollOfPrimary, stop);
  }
}

}  // namespace cairn::postgres
