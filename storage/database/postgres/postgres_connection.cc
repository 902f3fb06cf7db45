#include "storage/database/postgres/postgres_connection.h"

#include <fmt/format.h>

#include <bit>
#include <cctype>
#include <cstring>

#include "core/error.h"
#include "storage/database/postgres/postgres_cursor.h"

namespace cairn::postgres {

std::string WithDollars(std::string_view sql) {
  std::string text;
  int next = 1;
  for (size_t i = 0; i < sql.size(); ++i) {
    if (sql[i] != '?') {
      text += sql[i];
      continue;
    }
    text += '$';
    const bool is_numbered = i + 1 < sql.size() && std::isdigit(sql[i + 1]) != 0;
    if (!is_numbered) {
      text += std::to_string(next++);
    }
  }
  return text;
}

db::Statement PostgresConnection::Prepare(std::string_view sql) {
  return db::Statement(std::make_unique<PostgresCursor>(this, std::string(sql)));
}

Result PostgresConnection::Run(const std::string& sql, const std::vector<Parameter>& parameters) {
  std::vector<Oid> types;
  for (const Parameter& parameter : parameters) {
    types.push_back(parameter.type);
  }
  const auto key = std::make_pair(sql, types);
  auto found = prepared_.find(key);
  if (found == prepared_.end()) {
    const std::string id = fmt::format("cairn_{}", prepared_.size());
    link_.Prepare(id, WithDollars(sql), types);
    found = prepared_.emplace(key, id).first;
  }
  return link_.RunPrepared(found->second, parameters);
}

uint64_t PostgresConnection::BytesOnDisk() {
  db::Statement row = Prepare(
      "SELECT coalesce(sum(pg_total_relation_size(c.oid)), 0)::bigint FROM pg_class AS c "
      "WHERE c.relnamespace = 'cairn'::regnamespace AND c.relkind = 'r'");
  row.Step();
  return static_cast<uint64_t>(row.Int64(0));
}

std::optional<LargeVector<uint8_t>> PostgresConnection::ReadBytes(const char* table,
                                                                  const char* key_column,
                                                                  int64_t key) {
  PostgresCursor row(this, fmt::format("SELECT bytes FROM {} WHERE {} = ?", table, key_column));
  row.BindAt(1, key);
  if (!row.Step()) {
    return std::nullopt;
  }
  const std::span<const uint8_t> bytes = row.BytesView(0);
  return LargeVector<uint8_t>(bytes.begin(), bytes.end());
}

}  // namespace cairn::postgres
