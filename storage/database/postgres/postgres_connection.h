// A connection to PostgreSQL as a db::Connection.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_POSTGRES_CONNECTION_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_POSTGRES_CONNECTION_H_

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "storage/database/connection.h"
#include "storage/database/postgres/link.h"

namespace cairn::postgres {

// All rows of a statement must fit into memory. Values are sent and received in binary.
class PostgresConnection : public db::Connection {
 public:
  explicit PostgresConnection(Link link) : link_(std::move(link)) {}

  Link& link() { return link_; }

  // The newest version of the map that this connection has shown. A server never goes back.
  int64_t shown_version = 0;

  const std::string& name() const override { return link_.name(); }
  db::Dialect dialect() const override { return db::Dialect::kPostgres; }
  uint64_t BytesOnDisk() override;
  void Execute(const std::string& script) override { link_.Run(script); }
  db::Statement Prepare(std::string_view sql) override;
  std::optional<LargeVector<uint8_t>> ReadBytes(const char* table, const char* key_column,
                                                int64_t key) override;

  // Runs a statement with the parameters ?, or ?1, ?2, ... Compiles the statement at its first use
  // with these types of parameters.
  Result Run(const std::string& sql, const std::vector<Parameter>& parameters);

 private:
  Link link_;
  // The names of prepared statements by text and types.
  std::map<std::pair<std::string, std::vector<Oid>>, std::string> prepared_;
};

// Replaces ? by $1, $2, ... and ?1 by $1.
std::string WithDollars(std::string_view sql);

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_POSTGRES_CONNECTION_H_
