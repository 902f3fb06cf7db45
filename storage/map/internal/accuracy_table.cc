#include "storage/map/internal/accuracy_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <unordered_map>

#include "core/error.h"
#include "sql/schema.h"

namespace cairn::accuracy_table {
namespace {

// Columns: in_map_m, on_earth_m, on_earth_rad, from the first.
SessionAccuracy Read(const db::Connection& connection, const db::Statement& row, int first) {
  const SessionAccuracy accuracy = {row.Double(first), row.Double(first + 1),
                                    row.Double(first + 2)};
  if (!IsValid(accuracy)) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: table {} has impossible numbers", connection.name(), kName));
  }
  return accuracy;
}

}  // namespace

bool Exists(db::Connection* connection) {
  db::Statement row = connection->Prepare(
      connection->dialect() == db::Dialect::kSqlite
          ? "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = 'session_accuracy'"
          : "SELECT count(*) FROM pg_tables WHERE schemaname = 'cairn' AND tablename = "
            "'session_accuracy'");
  return row.Step() && row.Int64(0) != 0;
}

void Attach(db::Connection* connection, std::vector<SessionRecord>* sessions) {
  if (sessions->empty() || !Exists(connection)) {
    return;
  }
  std::unordered_map<SessionId, SessionAccuracy> accuracy_of;
  db::Statement row = connection->Prepare(
      "SELECT session_id, in_map_m, on_earth_m, on_earth_rad FROM session_accuracy "
      "WHERE session_id BETWEEN ? AND ?");
  const auto [least, most] = std::minmax_element(
      sessions->begin(), sessions->end(),
      [](const SessionRecord& a, const SessionRecord& b) { return a.id < b.id; });
  row.Bind(Value(least->id), Value(most->id));
  while (row.Step()) {
    accuracy_of.emplace(SessionId(row.Int64(0)), Read(*connection, row, 1));
  }
  for (SessionRecord& session : *sessions) {
    if (const auto found = accuracy_of.find(session.id); found != accuracy_of.end()) {
      session.accuracy = found->second;
    }
  }
}

std::vector<SessionAccuracy> Find(db::Connection* connection,
                                  const std::vector<SessionId>& session_ids) {
  std::vector<SessionAccuracy> accuracies;
  if (session_ids.empty() || !Exists(connection)) {
    return accuracies;
  }
  for (const SessionId session_id : session_ids) {
    db::Statement row = connection->Prepare(
        "SELECT in_map_m, on_earth_m, on_earth_rad FROM session_accuracy WHERE session_id = ?");
    if (row.Bind(Value(session_id)).Step()) {
      accuracies.push_back(Read(*connection, row, 0));
    }
  }
  return accuracies;
}

void Keep(db::Connection* connection, SessionId session_id, const SessionAccuracy& accuracy) {
  if (!Exists(connection)) {
    if (connection->dialect() == db::Dialect::kPostgres) {
      return;
    }
    connection->Execute(std::string(sql::k_session_accuracy_sql));
  }
  connection
      ->Prepare(
          "INSERT INTO session_accuracy (session_id, in_map_m, on_earth_m, on_earth_rad) "
          "VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING")
      .Bind(Value(session_id), accuracy.in_map_m, accuracy.on_earth_m, accuracy.on_earth_rad)
      .Run();
}

void DropUnused(db::Connection* connection) {
  if (Exists(connection)) {
    connection->Execute(
        "DELETE FROM session_accuracy WHERE session_id NOT IN ("
        "SELECT session_id FROM cairn_sessions UNION SELECT session_id FROM cairn_past_sessions)");
  }
}

}  // namespace cairn::accuracy_table
