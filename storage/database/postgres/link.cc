#include "storage/database/postgres/link.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <utility>

#include "core/error.h"
#include "storage/database/postgres/errors.h"

namespace cairn::postgres {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Returns the milliseconds until that time, at least 0, rounded up.
int MillisecondsUntil(Clock::time_point until) {
  const auto left = std::chrono::ceil<milliseconds>(until - Clock::now()).count();
  return static_cast<int>(std::clamp<int64_t>(left, 0, 3'600'000));
}

// Returns true if the socket is ready before that time. A signal does not end the wait.
bool PollUntil(int socket, short events, Clock::time_point until) {
  pollfd entry{socket, events, 0};
  while (true) {
    const int num_ready = poll(&entry, 1, MillisecondsUntil(until));
    if (num_ready > 0) {
      return true;
    }
    if (num_ready == 0 || errno != EINTR) {
      return false;
    }
  }
}

Clock::time_point EndOf(const Patience& patience) {
  const Clock::time_point silence_ends = Clock::now() + patience.silence;
  return patience.deadline ? std::min(*patience.deadline, silence_ends) : silence_ends;
}

void IgnoreNotice(void* /*user_data*/, const char* /*message*/) {}

}  // namespace

Link::Link(const std::vector<Settings>& hosts, const std::string& name, const Patience& patience)
    : name_(name), patience_(patience), connection_(nullptr, &PQfinish) {
  std::optional<Error> problem;
  for (const Settings& host : hosts) {
    try {
      connection_ = ConnectTo(host, patience);
      PQsetnonblocking(connection_.get(), 1);
      is_broken_ = false;
      return;
    } catch (const Error& error) {
      // A refusal says more than a host that does not answer.
      if (!problem || problem->code() == ErrorCode::kUnavailable) {
        problem = error;
      }
    }
  }
  throw *problem;
}

Link::Connection Link::ConnectTo(const Settings& host, const Patience& patience) {
  std::vector<const char*> keywords, values;
  for (const auto& [keyword, value] : host) {
    keywords.push_back(keyword.c_str());
    values.push_back(value.c_str());
  }
  keywords.push_back(nullptr);
  values.push_back(nullptr);
  Connection connection(PQconnectStartParams(keywords.data(), values.data(), 0), &PQfinish);
  if (connection == nullptr) {
    throw std::bad_alloc();
  }
  PQsetNoticeProcessor(connection.get(), &IgnoreNotice, nullptr);
  // Messages with SQLSTATE, because the server's language may be any.
  PQsetErrorVerbosity(connection.get(), PQERRORS_VERBOSE);
  PostgresPollingStatusType status = PGRES_POLLING_WRITING;
  while (status != PGRES_POLLING_OK && PQstatus(connection.get()) != CONNECTION_BAD &&
         status != PGRES_POLLING_FAILED) {
    Wait(connection.get(), status == PGRES_POLLING_READING ? POLLIN : POLLOUT, patience);
    status = PQconnectPoll(connection.get());
  }
  if (status != PGRES_POLLING_OK) {
    throw ConnectError(name_, PQerrorMessage(connection.get()));
  }
  return connection;
}

void Link::Break(const std::string& problem) {
  is_broken_ = true;
  throw Error(ErrorCode::kUnavailable, name_ + ": " + problem);
}

void Link::Wait(PGconn* connection, short events, const Patience& patience) {
  if (!PollUntil(PQsocket(connection), events, EndOf(patience))) {
    Break("the PostgreSQL server does not answer; try again");
  }
}

bool Link::IsUsable() {
  if (is_broken_ || PQstatus(connection_.get()) != CONNECTION_OK) {
    return false;
  }
  // Data on an idle connection is a notice or the end of the connection. The link is not reused in
  // either case, so there is no need to find out.
  return PQtransactionStatus(connection_.get()) == PQTRANS_IDLE &&
         !PollUntil(PQsocket(connection_.get()), POLLIN, Clock::time_point{});
}

void Link::RequireSent(int sent) {
  if (sent == 0) {
    Break("the connection to the PostgreSQL server is lost; try again");
  }
}

void Link::Flush() {
  while (true) {
    const int unsent = PQflush(connection_.get());
    RequireSent(unsent < 0 ? 0 : 1);
    if (unsent == 0) {
      return;
    }
    Wait(connection_.get(), POLLIN | POLLOUT, patience_);
    RequireSent(PQconsumeInput(connection_.get()));
  }
}

// Reads all results of the statements sent. Returns the first failure, or else the last result.
Result Link::Receive() {
  Flush();
  Result kept(nullptr, &PQclear);
  while (true) {
    while (PQisBusy(connection_.get()) != 0) {
      Wait(connection_.get(), POLLIN, patience_);
      RequireSent(PQconsumeInput(connection_.get()));
    }
    Result result(PQgetResult(connection_.get()), &PQclear);
    if (result == nullptr) {
      break;
    }
    const bool has_failed = kept != nullptr && PQresultStatus(kept.get()) == PGRES_FATAL_ERROR;
    if (!has_failed) {
      kept = std::move(result);
    }
  }
  if (kept == nullptr) {
    Break("the PostgreSQL server sent no result");
  }
  if (PQresultStatus(kept.get()) == PGRES_FATAL_ERROR) {
    const char* state = PQresultErrorField(kept.get(), PG_DIAG_SQLSTATE);
    is_broken_ = EndsConnection(state == nullptr ? "" : state);
    throw StatementError(name_, kept.get());
  }
  return kept;
}

Result Link::Run(const std::string& script) {
  RequireSent(is_broken_ ? 0 : PQsendQuery(connection_.get(), script.c_str()));
  return Receive();
}

void Link::Prepare(const std::string& id, const std::string& sql, const std::vector<Oid>& types) {
  RequireSent(is_broken_ ? 0
                         : PQsendPrepare(connection_.get(), id.c_str(), sql.c_str(),
                                         static_cast<int>(types.size()), types.data()));
  Receive();
}

Result Link::RunPrepared(const std::string& id, std::span<const Parameter> parameters) {
  std::vector<const char*> values;
  std::vector<int> lengths, formats;
  for (const Parameter& parameter : parameters) {
    values.push_back(parameter.data);
    lengths.push_back(parameter.num_bytes);
    formats.push_back(1);
  }
  RequireSent(is_broken_ ? 0
                         : PQsendQueryPrepared(connection_.get(), id.c_str(),
                                               static_cast<int>(values.size()), values.data(),
                                               lengths.data(), formats.data(), 1));
  return Receive();
}

bool Link::WaitForNotification(Clock::time_point until) {
  while (true) {
    bool has_some = false;
    while (PGnotify* notification = PQnotifies(connection_.get())) {
      PQfreemem(notification);
      has_some = true;
    }
    if (has_some) {
      return true;
    }
    if (!PollUntil(PQsocket(connection_.get()), POLLIN, until)) {
      return false;
    }
    RequireSent(PQconsumeInput(connection_.get()));
  }
}

}  // namespace cairn::postgres
