#include "storage/database/postgres/connection_pool.h"

#include <chrono>
#include <utility>

#include "core/error.h"

namespace cairn::postgres {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kLongestWait{30};  // For a reader without a deadline.

}  // namespace

// Counts the caller as a borrower. Returns null if the caller may make a new connection.
std::unique_ptr<PostgresConnection> ConnectionPool::TakeIdle(db::Deadline deadline) {
  std::unique_lock lock(mutex_);
  const auto has_room = [this] { return num_borrowed_ < kMaxConnections; };
  if (!given_back_.wait_until(lock, deadline.value_or(Clock::now() + kLongestWait), has_room)) {
    throw Error(ErrorCode::kUnavailable,
                server_->name() + ": all connections to the server are in use; try again");
  }
  ++num_borrowed_;
  while (!idle_.empty()) {
    std::unique_ptr<PostgresConnection> connection = std::move(idle_.back());
    idle_.pop_back();
    if (connection->link().IsUsable()) {
      return connection;
    }
  }
  return nullptr;
}

std::unique_ptr<PostgresConnection> ConnectionPool::Take(db::Deadline deadline) {
  std::unique_ptr<PostgresConnection> connection = TakeIdle(deadline);
  const Patience patience{deadline, silence_};
  try {
    if (connection == nullptr) {
      connection = server_->Connect(Use::kRead, patience);
    }
  } catch (...) {
    GiveBack(nullptr);
    throw;
  }
  connection->link().set_patience(patience);
  return connection;
}

void ConnectionPool::GiveBack(std::unique_ptr<PostgresConnection> connection) {
  const bool is_usable = connection != nullptr && connection->link().IsUsable();
  std::vector<std::unique_ptr<PostgresConnection>> dropped;
  {
    const std::lock_guard lock(mutex_);
    --num_borrowed_;
    if (is_usable) {
      idle_.push_back(std::move(connection));
    } else {
      // The idle connections are probably as dead, and each would cost a query its deadline.
      dropped.swap(idle_);
    }
  }
  given_back_.notify_one();
}

}  // namespace cairn::postgres
