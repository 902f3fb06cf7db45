// The last step of an ingest: makes the built tiles of a plan the next version of the map.
#ifndef CAIRN_INGEST_PUBLISH_SESSION_H_
#define CAIRN_INGEST_PUBLISH_SESSION_H_

#include <chrono>
#include <cstddef>
#include <functional>

#include "ingest/ingest_report.h"
#include "ingest/session_plan.h"
#include "ingest/session_tile_builder.h"
#include "storage/map/map_store.h"

namespace cairn {

// Writes the session, its keyframes and its tiles in one transaction: readers see all of it or
// nothing. `load` returns the built tile of plan.tiles[tile_idx]; tiles are asked for in order.
// Waits as long as `patience` says while another update runs. `progress` may be empty.
//
// Other updates may have been published since the plan was made, as long as they left the plan's
// tiles alone. Throws Error(kConflict), which changes nothing, if
//  - tiles of the plan have other content than the plan starts from; the message names them;
//  - the session was published, added, replaced or removed since, or the map has the same
//    reconstruction under another name;
//  - the map is not that of the plan, or an older copy of it, or has got another codebook.
IngestReport PublishSession(const SessionPlan& plan,
                            const std::function<BuiltTile(size_t tile_idx)>& load, MapStore* store,
                            std::chrono::milliseconds patience, const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_PUBLISH_SESSION_H_
