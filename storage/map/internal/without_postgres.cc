// Stands for postgres_backend.cc in a Cairn that was built without libpq.
#include "core/error.h"
#include "storage/map/internal/postgres_backend.h"

namespace cairn {
namespace {

[[noreturn]] void Refuse() {
  throw Error(ErrorCode::kUnavailable,
              "this Cairn was built without PostgreSQL; install libpq-dev and build it again");
}

}  // namespace

std::unique_ptr<MapBackend> OpenPostgresMap(const std::string& /*url*/, OpenMode /*mode*/) {
  Refuse();
}

void CreatePostgresMap(const std::string& /*url*/) { Refuse(); }

void DropPostgresMap(const std::string& /*url*/) { Refuse(); }

}  // namespace cairn
