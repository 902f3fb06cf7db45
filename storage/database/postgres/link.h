// One connection to a PostgreSQL server on which every wait has a deadline.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_LINK_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_LINK_H_

#include <libpq-fe.h>

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "storage/database/deadline.h"
#include "storage/database/postgres/address.h"

namespace cairn::postgres {

using Result = std::unique_ptr<PGresult, decltype(&PQclear)>;

// A parameter in PostgreSQL's binary format. `data` is null for NULL.
struct Parameter {
  Oid type = 0;
  const char* data = nullptr;
  int num_bytes = 0;
};

// A statement of a program that nobody waits for may compute for long before it sends anything.
inline constexpr std::chrono::minutes kLongSilence{10};

// How long to wait for the server.
struct Patience {
  db::Deadline deadline = {};
  // The longest time without a byte from the server.
  std::chrono::milliseconds silence = kLongSilence;
};

// Uses libpq's asynchronous functions and poll(). A failed connection and a wait beyond its limit
// break the link. Every further use of a broken link throws Error(kUnavailable). Use each link from
// one thread at a time.
class Link {
 public:
  // Tries the hosts in order. `name` is for messages. Throws the errors of ConnectError.
  Link(const std::vector<Settings>& hosts, const std::string& name, const Patience& patience);

  void set_patience(const Patience& patience) { patience_ = patience; }
  // Returns false if the link is broken, if the server has closed the connection, or if there is
  // anything to read. Costs a system call.
  bool IsUsable();

  // Runs statements without parameters and returns the result of the last one. Throws the errors of
  // StatementError.
  Result Run(const std::string& script);
  void Prepare(const std::string& id, const std::string& sql, const std::vector<Oid>& types);
  Result RunPrepared(const std::string& id, std::span<const Parameter> parameters);

  // Waits for a notification. Returns false if none comes in time.
  bool WaitForNotification(std::chrono::steady_clock::time_point until);

  const std::string& name() const { return name_; }

 private:
  using Connection = std::unique_ptr<PGconn, decltype(&PQfinish)>;

  Connection ConnectTo(const Settings& host, const Patience& patience);
  // Waits until the socket is ready; throws Error(kUnavailable) and breaks the link otherwise.
  void Wait(PGconn* connection, short events, const Patience& patience);
  void RequireSent(int sent);
  void Flush();
  Result Receive();
  [[noreturn]] void Break(const std::string& problem);

  std::string name_;
  Patience patience_;
  bool is_broken_ = false;
  Connection connection_;
};

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_LINK_H_
