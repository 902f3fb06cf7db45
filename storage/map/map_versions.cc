#include "storage/map/map_versions.h"

#include "core/error.h"

namespace cairn {

const char* VersionKindName(VersionKind kind) {
  switch (kind) {
    case VersionKind::kEdit:
      return "edit";
    case VersionKind::kCreate:
      return "create";
    case VersionKind::kIngest:
      return "ingest";
    case VersionKind::kReplace:
      return "replace";
    case VersionKind::kRemove:
      return "remove";
    case VersionKind::kRollback:
      return "rollback";
    case VersionKind::kPrune:
      return "prune";
    case VersionKind::kMerge:
      return "merge";
    case VersionKind::kExtract:
      return "extract";
    case VersionKind::kRecode:
      return "recode";
  }
  throw Error(ErrorCode::kInternal, "unknown kind of version");
}

}  // namespace cairn
