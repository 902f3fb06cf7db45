// A PostgreSQL database with its URL. Makes connections.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_SERVER_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_SERVER_H_

#include <memory>
#include <string>
#include <vector>

#include "storage/database/postgres/address.h"
#include "storage/database/postgres/postgres_connection.h"

namespace cairn::postgres {

enum class Use {
  kRead,   // Any host of the URL, including standbys. The connection is read-only.
  kWrite,  // The host that is the primary.
};

// Safe to use from any thread.
class Server {
 public:
  // Throws as ParseAddress. Does not connect.
  explicit Server(const std::string& url);

  const std::string& name() const { return name_; }  // The URL, which has no password.

  // Throws Error: see ConnectError. Messages never hold the password.
  std::unique_ptr<PostgresConnection> Connect(Use use, const Patience& patience) const;

 private:
  std::string name_;
  std::vector<Settings> hosts_;
};

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_SERVER_H_
