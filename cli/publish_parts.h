// A session of photos whose parts nothing connects joins a map.
#ifndef CAIRN_CLI_PUBLISH_PARTS_H_
#define CAIRN_CLI_PUBLISH_PARTS_H_

#include <functional>

#include "cli/publish_in_turn.h"
#include "cli/session_arguments.h"
#include "ingest/ingest_report.h"
#include "storage/map/map_store.h"

namespace cairn {

// Publishes a session as it is. Throws as IngestSession.
using PublishPlaced = std::function<IngestReport(const PlacedReconstruction& session)>;

// Publishes the session where its positions place it. Throws SessionRefused, with the reason of the
// largest segment, if they place none.
IngestReport PublishAsPlaced(const PublishPlaced& publish, const MapSessionResult& result);

// Places the segments that their positions do not place where the map sees them (PlaceByMap), moves
// all segments to where the map sees them, each by itself (FitParts), and then publishes them as
// one session. Says in `mapped` how far segments moved, and which of them stay out, also in
// `unplaced`; `session` becomes what was published. A session of one segment that its positions
// place is published as it is. If `publish` throws, `result` is as before. Throws SessionRefused if
// no segment is left.
IngestReport PublishParts(const MapSnapshot& map, const PublishPlaced& publish,
                          MapSessionResult* result);

// Tries the segments that a published session lacks (MappedPhotos::unplaced) once more, as
// PublishParts does, with a map that has got more since. If the map places any and also anchors a
// segment that is published, publishes the session again with them; its other segments go in as
// they did before. A few photos that the map places thus never turn a walk over new ground. If the
// map refuses the session with them, or places none, the session stays as it is, and the reports
// say why. Throws what `publish` throws, other than SessionRefused.
void PublishLeftOut(const MapSnapshot& map, const PublishPlaced& publish, MapSessionResult* result);

}  // namespace cairn

#endif  // CAIRN_CLI_PUBLISH_PARTS_H_
