// The time by which a call to a database must end.
#ifndef CAIRN_STORAGE_DATABASE_DEADLINE_H_
#define CAIRN_STORAGE_DATABASE_DEADLINE_H_

#include <chrono>
#include <optional>

namespace cairn::db {

using Deadline = std::optional<std::chrono::steady_clock::time_point>;  // Empty for no limit.

}  // namespace cairn::db

#endif  // CAIRN_STORAGE_DATABASE_DEADLINE_H_
