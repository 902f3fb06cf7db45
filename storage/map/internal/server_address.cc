#include "storage/map/internal/postgres_backend.h"

namespace cairn {

bool IsServerAddress(const std::string& path) {
  return path.starts_with("postgresql://") || path.starts_with("postgres://");
}

}  // namespace cairn
