// From a reconstruction to tiles in a map: the whole of `cairn ingest`.
#ifndef CAIRN_INGEST_INGEST_SESSION_H_
#define CAIRN_INGEST_INGEST_SESSION_H_

#include <functional>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "ingest/ingest_options.h"
#include "ingest/ingest_report.h"
#include "ingest/plan_session.h"
#include "ingest/session_plan.h"
#include "storage/map/map_store.h"

namespace cairn {

// Called once the tiles are built, before the map is locked and the version published. If it
// throws, nothing is published. Also called if the map has the session already
// (SessionPlan::is_unchanged).
using BeforePublish = std::function<void(const PlannedSession& planned)>;

// PlanSession, SessionTileBuilder and PublishSession in one process. Writes one session in one
// transaction: readers see all of it or nothing. `ecef_from_world` places the reconstruction (see
// georegister.h). With SessionJoining::kJoin, the session moves to where the map sees it. Its
// observations update the landmarks that the map knows. Landmarks that earlier sessions saw, and
// that this session should have seen but did not, fade. The same session again changes nothing.
// `progress` is called by one thread at a time, not always the same.
//
// Throws Error(kBadInput) if the descriptor type or dimension is not the map's; Error(kConflict) if
// another update runs or changed the same tiles meanwhile, or, with SessionJoining::kJoin, if the
// session contradicts the map or the map has the same reconstruction under another name.
IngestReport IngestSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress,
                           const BeforePublish& before_publish = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_INGEST_SESSION_H_
