// Reads and writes the table of the accuracy of sessions. Private to storage.
//
// Maps of programs before the table lack it: their sessions have no accuracy. A file gets the table
// with its first session that has one. A PostgreSQL map gets it only when it is created, because
// roles that publish may not create tables. Rows never change, since ids of sessions are never
// reused, so versions need no rows of their own.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_ACCURACY_TABLE_H_
#define CAIRN_STORAGE_MAP_INTERNAL_ACCURACY_TABLE_H_

#include <optional>
#include <vector>

#include "storage/database/connection.h"
#include "storage/ids.h"
#include "storage/map/map_store.h"

namespace cairn::accuracy_table {

inline constexpr const char* kName = "session_accuracy";

bool Exists(db::Connection* connection);

// Sets `accuracy` of each session that has one. Throws Error(kMapDamaged) for impossible numbers.
void Attach(db::Connection* connection, std::vector<SessionRecord>* sessions);

// Returns the accuracies that the map has of these sessions, in any order.
std::vector<SessionAccuracy> Find(db::Connection* connection,
                                  const std::vector<SessionId>& session_ids);

// Adds the row of a session, and the table if a file lacks it. The row stays if there is one.
void Keep(db::Connection* connection, SessionId session_id, const SessionAccuracy& accuracy);

// Deletes the rows of sessions that no version has.
void DropUnused(db::Connection* connection);

}  // namespace cairn::accuracy_table

#endif  // CAIRN_STORAGE_MAP_INTERNAL_ACCURACY_TABLE_H_
