// Where a session stands once the map has been asked. Private to ingest.
#ifndef CAIRN_INGEST_SESSION_PLACEMENT_H_
#define CAIRN_INGEST_SESSION_PLACEMENT_H_

#include <string>

#include "ingest/coregister/compare_with_map.h"
#include "ingest/ingest_options.h"
#include "ingest/tiling/placed_session.h"

namespace cairn {

// Throws Error(kConflict), with the figures of the disagreement and what to do, if a session or
// another map contradicts the map: the map recognizes none of its photos, or recognizes them
// elsewhere, turned, of another size or in places that fit no motion. `newcomer` names it.
void RequireAgreement(const MapComparison& comparison, const AgreementOptions& limits,
                      const std::string& newcomer);

// The session moved to where the map sees it, or as it is if the map recognizes too few photos.
PlacedSession SettleSession(PlacedSession session, const MapComparison& comparison,
                            const Reconstruction& reconstruction);

}  // namespace cairn

#endif  // CAIRN_INGEST_SESSION_PLACEMENT_H_
