#include "cli/ingest_placed.h"

#include "core/rigid3.h"
#include "ingest/ingest_session.h"

namespace cairn {

std::unique_ptr<SessionArchive> OpenSessionArchive(const std::string& path,
                                                   const std::string& session_name,
                                                   const MapStore& store) {
  return path.empty() ? nullptr : std::make_unique<SessionArchive>(path, session_name, store);
}

IngestReport IngestPlaced(const PlacedReconstruction& session, CairnOptions options,
                          SessionArchive* archive, const IngestProgress& progress,
                          MapStore* store) {
  options.ingest = session.options;
  // What a map took once belongs to it, also if a rebuild leaves out what anchored it.
  CairnOptions archived = options;
  archived.ingest.agreement.unanchored = Unanchored::kAccept;
  const Sim3d& ecef_from_world = session.georegistration.ecef_from_world;
  const IngestReport report = IngestSession(session.reconstruction, ecef_from_world, options.ingest,
                                            store, progress, [&](const PlannedSession& planned) {
                                              if (archive != nullptr) {
                                                archive->Stage(planned, ecef_from_world, archived);
                                              }
                                            });
  if (archive != nullptr) {
    archive->Commit();
  }
  return report;
}

}  // namespace cairn
