#include "storage/map/internal/postgres_backend.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel_for.h"
#include "storage/database/postgres/connection_pool.h"
#include "storage/database/postgres/head_watcher.h"
#include "storage/database/postgres/schema.h"
#include "storage/map/internal/head_writer.h"
#include "storage/map/internal/map_file.h"
#include "storage/map/internal/version_queries.h"

namespace cairn {
namespace {

using postgres::PostgresConnection;

// A server that answers queries gives up on a frozen database after this time, so that its clients
// can ask another server.
constexpr std::chrono::seconds kSilenceOfServing{2};
// A standby has a version some milliseconds after the primary.
constexpr std::chrono::milliseconds kLagOfStandby{500}, kPauseOfWait{10};

// Waits until the host of the connection, which may be another one than the watcher's, has that
// version. Throws Error(kUnavailable) if it still lacks the version after the usual lag or at the
// deadline.
void WaitForVersion(int64_t version, ReadDeadline deadline, PostgresConnection* connection) {
  const auto usual_end = std::chrono::steady_clock::now() + kLagOfStandby;
  const auto end = deadline ? std::min(usual_end, *deadline) : usual_end;
  while (connection->shown_version < version) {
    if (std::chrono::steady_clock::now() > end) {
      throw Error(ErrorCode::kUnavailable,
                  connection->name() + ": this standby lacks the latest version; try again");
    }
    connection->shown_version = Value(queries::LatestVersion(connection));
    if (connection->shown_version < version) {
      std::this_thread::sleep_for(kPauseOfWait);
    }
  }
}

// Any program that updates a map holds this lock until its transaction ends: "cairn" in ASCII.
constexpr const char* kTakeUpdateLock = "SELECT pg_try_advisory_xact_lock(426970575214)";

void RequireFormat(db::Connection* connection) {
  db::Statement row =
      connection->Prepare("SELECT format_version, oldest_reader_version FROM cairn_map");
  if (!row.Step()) {
    throw Error(ErrorCode::kMapDamaged, connection->name() + ": the table cairn_map is empty");
  }
  if (row.Int64(1) > kMapFormatVersion) {
    throw Error(ErrorCode::kConflict,
                connection->name() + ": is a map of a newer format; use a newer Cairn");
  }
}

class PostgresWriteTransaction : public WriteTransaction {
 public:
  explicit PostgresWriteTransaction(std::unique_ptr<PostgresConnection> connection)
      : connection_(std::move(connection)) {
    connection_->Execute("BEGIN");
    postgres::RequireMayWrite(connection_.get());
    db::Statement lock = connection_->Prepare(kTakeUpdateLock);
    lock.Step();
    if (lock.Int64(0) == 0) {
      throw Error(ErrorCode::kConflict, connection_->name() +
                                            ": another update of this map is running; try again "
                                            "when it has finished");
    }
  }

  db::Connection* connection() override { return connection_.get(); }

  void Commit() override {
    connection_->Execute("NOTIFY cairn_head");
    connection_->Execute("COMMIT");
  }

 private:
  std::unique_ptr<PostgresConnection> connection_;  // Closing it rolls back unless committed.
};

class PostgresBackend : public MapBackend {
 public:
  PostgresBackend(const std::string& url, OpenMode mode)
      : mode_(mode),
        server_(url),
        pool_(&server_, mode == OpenMode::kServing ? kSilenceOfServing : postgres::kLongSilence) {
    std::unique_ptr<PostgresConnection> first = pool_.Take({});
    postgres::RequireSchema(first.get());
    RequireFormat(first.get());
    if (mode == OpenMode::kServing) {
      watcher_.emplace(&server_, Value(queries::LatestVersion(first.get())));
      MakeConnections();
    }
    pool_.GiveBack(std::move(first));
  }

  const std::string& name() const override { return server_.name(); }

  std::optional<MapHead> KnownHead() const override {
    if (!watcher_) {
      return std::nullopt;
    }
    const postgres::HeadWatcher::Head head = watcher_->head();
    return MapHead{MapVersion(head.version), head.is_silent, head.num_losses};
  }

  std::unique_ptr<db::Connection> Take(ReadDeadline deadline) override {
    if (watcher_ && watcher_->head().is_silent) {
      throw Error(ErrorCode::kUnavailable,
                  name() + ": the PostgreSQL server does not answer; try again");
    }
    std::unique_ptr<PostgresConnection> connection = pool_.Take(deadline);
    try {
      if (watcher_) {
        WaitForVersion(watcher_->head().version, deadline, connection.get());
      }
    } catch (...) {
      pool_.GiveBack(std::move(connection));
      throw;
    }
    return connection;
  }

  void GiveBack(std::unique_ptr<db::Connection> connection) override {
    pool_.GiveBack(std::unique_ptr<PostgresConnection>(
        static_cast<PostgresConnection*>(connection.release())));
  }

  std::unique_ptr<WriteTransaction> BeginUpdate() override {
    if (mode_ != OpenMode::kReadWrite) {
      throw Error(ErrorCode::kConflict, name() + ": was opened read-only");
    }
    return std::make_unique<PostgresWriteTransaction>(server_.Connect(postgres::Use::kWrite, {}));
  }

  MapFileState FileState() const override { return MapFileState::kInPlace; }
  std::string LogPath() const override { return {}; }

 private:
  // A query fetches payloads in parallel, each over its own connection. Makes these connections in
  // advance, so that the first query does not wait for them.
  void MakeConnections() {
    std::vector<std::unique_ptr<PostgresConnection>> connections;
    for (int i = 0; i < std::min(NumCores(), 8); ++i) {
      connections.push_back(pool_.Take({}));
    }
    for (std::unique_ptr<PostgresConnection>& connection : connections) {
      pool_.GiveBack(std::move(connection));
    }
  }

  const OpenMode mode_;
  const postgres::Server server_;
  postgres::ConnectionPool pool_;
  std::optional<postgres::HeadWatcher> watcher_;
};

}  // namespace

std::unique_ptr<MapBackend> OpenPostgresMap(const std::string& url, OpenMode mode) {
  return std::make_unique<PostgresBackend>(url, mode);
}

void CreatePostgresMap(const std::string& url) {
  const auto connection = postgres::Server(url).Connect(postgres::Use::kWrite, {});
  connection->Execute("BEGIN");
  postgres::InstallSchema(connection.get());
  AddFirstVersion(connection.get());
  connection->Execute("COMMIT");
}

void DropPostgresMap(const std::string& url) {
  postgres::DropSchema(postgres::Server(url).Connect(postgres::Use::kWrite, {}).get());
}

}  // namespace cairn
