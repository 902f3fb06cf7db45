#include "storage/map/internal/id_counters.h"

#include <fmt/format.h>

#include <string_view>

#include "core/check.h"
#include "core/error.h"

namespace cairn {
namespace {

constexpr int64_t kMaxId = int64_t{1} << 62;

// In a file, the table whose key SQLite counts on; on a server, the sequence.
struct CounterNames {
  std::string_view table;
  std::string_view sequence;
};

CounterNames NamesOf(IdCounter counter) {
  switch (counter) {
    case IdCounter::kSession:
      return {"cairn_sessions", "cairn_session_ids"};
    case IdCounter::kKeyframe:
      return {"keyframes", "cairn_keyframe_ids"};
    case IdCounter::kCodebook:
      return {"cairn_codebooks", "cairn_codebook_ids"};
  }
  throw Error(ErrorCode::kInternal, "unknown IdCounter");
}

void SetLastId(db::Connection* connection, const CounterNames& names, int64_t last_id) {
  if (connection->dialect() == db::Dialect::kPostgres) {
    connection->Prepare("SELECT setval(?::text::regclass, ?::bigint)")
        .Bind(names.sequence, last_id)
        .Run();
    return;
  }
  // SQLite makes the row with the first number that the table gets.
  db::Statement updated =
      connection->Prepare("UPDATE sqlite_sequence SET seq = ? WHERE name = ? RETURNING seq");
  if (updated.Bind(last_id, names.table).Step()) {
    updated.Step();
    return;
  }
  connection->Prepare("INSERT INTO sqlite_sequence (name, seq) VALUES (?, ?)")
      .Bind(names.table, last_id)
      .Run();
}

}  // namespace

int64_t NextId(db::Connection* connection, IdCounter counter) {
  const CounterNames names = NamesOf(counter);
  int64_t next_id = 1;
  if (connection->dialect() == db::Dialect::kPostgres) {
    db::Statement row = connection->Prepare(
        fmt::format("SELECT last_value + is_called::integer FROM {}", names.sequence));
    row.Step();
    next_id = row.Int64(0);
  } else {
    db::Statement row = connection->Prepare("SELECT seq FROM sqlite_sequence WHERE name = ?");
    next_id = row.Bind(names.table).Step() ? row.Int64(0) + 1 : 1;
  }
  if (next_id < 1 || next_id > kMaxId) {
    throw Error(ErrorCode::kMapDamaged, fmt::format("{}: the id counter of {} is out of range",
                                                    connection->name(), names.table));
  }
  return next_id;
}

int64_t TakeIds(db::Connection* connection, IdCounter counter, int64_t count) {
  CAIRN_CHECK(count >= 0 && count < kMaxId, "a map cannot number this many rows");
  const int64_t first = NextId(connection, counter);
  if (count > 0) {
    SetLastId(connection, NamesOf(counter), first + count - 1);
  }
  return first;
}

uint64_t TakeLandmarkIds(db::Connection* connection, uint64_t count) {
  constexpr uint64_t kMaxCount = uint64_t{1} << 48;  // Far below the limit of 63 bits.
  CAIRN_CHECK(count <= kMaxCount, "a map cannot number this many landmarks");
  db::Statement row = connection->Prepare(
      "UPDATE cairn_map SET next_landmark_id = next_landmark_id + ? RETURNING next_landmark_id");
  row.Bind(static_cast<int64_t>(count));
  if (!row.Step()) {
    throw Error(ErrorCode::kMapDamaged, connection->name() + ": the table cairn_map is empty");
  }
  const auto next_id = static_cast<uint64_t>(row.Int64(0));
  row.Step();
  return next_id - count;
}

}  // namespace cairn
