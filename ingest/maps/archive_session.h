// Conversion between the input of an ingest and an archived session.
#ifndef CAIRN_INGEST_MAPS_ARCHIVE_SESSION_H_
#define CAIRN_INGEST_MAPS_ARCHIVE_SESSION_H_

#include <string>
#include <vector>

#include "core/rigid3.h"
#include "ingest/ingest_report.h"
#include "ingest/maps/archive_folder.h"
#include "ingest/maps/archived_session.h"
#include "ingest/plan_session.h"
#include "storage/map/map_store.h"

namespace cairn {

// The sessions of a map as an archive compares them.
std::vector<MapSession> MapSessionsOf(const MapSnapshot& map);

ArchivedMap ArchivedMapOf(const MapSnapshot& map);

// The manifest of a session that is planned, or that the map has already
// (SessionPlan::is_unchanged). `options` are those of the plan; `options_json` holds the same as
// text.
ArchiveManifest MakeManifest(const PlannedSession& planned, const Sim3d& ecef_from_world,
                             const IngestOptions& options, const std::string& options_json);

enum class Numbering {
  kAsBefore,  // The ids that the session had in its map; ids between, which no session has, are
              // left out again. Ids that the archive does not know follow the map's.
  kDense,     // The ids that come next.
};

// Ingests an archived session as it was ingested before. `options` are those that the manifest's
// text says; name, times and all else come from the manifest. Throws what IngestSession throws, and
// Error(kMapDamaged) if the session has another content than its manifest says.
IngestReport IngestAgain(const ArchivedSession& session, IngestOptions options, Numbering numbering,
                         MapStore* store, const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_ARCHIVE_SESSION_H_
