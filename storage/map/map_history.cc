#include "storage/map/map_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

#include "core/error.h"
#include "core/require.h"
#include "storage/map/internal/map_file.h"
#include "storage/map/internal/postgres_backend.h"
#include "storage/map/utc_time.h"

namespace cairn {
namespace {

constexpr int64_t kAllVersions = std::numeric_limits<int64_t>::max();

// Returns the oldest version that Prune keeps. `versions` is newest first. Pruning adds a version,
// which counts as kept.
MapVersion OldestKept(const PruneOptions& options, const std::vector<VersionRecord>& versions) {
  const int64_t next = Value(versions.front().version) + 1;
  if (options.keep) {
    return *options.keep >= std::ssize(versions) ? versions.back().version
                                                 : MapVersion(next - *options.keep + 1);
  }
  // Finds the oldest version that was published since then. Clocks can go back between versions.
  int64_t oldest = next;
  for (const VersionRecord& version : versions) {
    if (version.created_at >= *options.older_than) {
      oldest = Value(version.version);
    }
  }
  return MapVersion(oldest);
}

}  // namespace

MapVersion RollBack(MapVersion version, MapStore* store) {
  MapUpdate update = store->BeginUpdate();
  if (version == update.base_version()) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: version {} is already the latest", store->path(), Value(version)));
  }
  update.RestoreVersion(version);
  return update.Publish({.kind = VersionKind::kRollback,
                         .summary = fmt::format("back to version {}", Value(version))});
}

void PruneOptions::Validate() const {
  RequireOption(keep.has_value() != older_than.has_value(),
                "prune needs either a number of versions to keep or a time");
  RequireOption(!keep || *keep >= 1, "prune.keep must be at least 1");
  RequireOption(!older_than || IsUtcTime(*older_than),
                "prune.older_than must be a time like 2026-01-31T12:00:00Z");
}

PruneReport Prune(const PruneOptions& options, MapStore* store) {
  options.Validate();
  MapUpdate update = store->BeginUpdate();  // Keeps others from publishing a version.
  const std::vector<VersionRecord> versions = store->Snapshot().Versions(kAllVersions);
  const MapVersion oldest_kept = OldestKept(options, versions);
  PruneReport report;
  report.version = versions.front().version;
  report.num_versions_gone = std::count_if(
      versions.begin(), versions.end(),
      [&](const VersionRecord& version) { return Value(version.version) < Value(oldest_kept); });
  if (report.num_versions_gone > 0) {
    report.num_payload_bytes_gone = update.PruneBefore(oldest_kept);
    report.version =
        update.Publish({.kind = VersionKind::kPrune,
                        .summary = fmt::format("deleted {} versions before version {}",
                                               report.num_versions_gone, Value(oldest_kept))});
  }
  return report;
}

void CompactMap(MapStore* store) {
  if (IsServerAddress(store->path())) {
    throw Error(ErrorCode::kInvalidArgument,
                store->path() +
                    ": only files can be compacted; autovacuum frees the space of a "
                    "PostgreSQL database, and VACUUM FULL returns it to the disk");
  }
  // Throws if the map may not be written, or if an update runs.
  { const MapUpdate update = store->BeginUpdate(); }
  const auto connection = OpenMapFileForUpdate(store->path());
  connection->LiftWorkLimit();
  connection->Execute("VACUUM");
  connection->Execute("PRAGMA wal_checkpoint(TRUNCATE)");
}

}  // namespace cairn
