// Tells sessions of the same photos apart from others. Private to ingest.
#ifndef CAIRN_INGEST_SESSION_DIGEST_H_
#define CAIRN_INGEST_SESSION_DIGEST_H_

#include <string>
#include <vector>

#include "core/rigid3.h"
#include "ingest/ingest_options.h"
#include "ingest/sfm/reconstruction.h"
#include "storage/map/map_store.h"

namespace cairn {

// 32 hexadecimal digits of XXH3: what the reconstruction holds. The order of its images and
// landmarks counts.
std::string DigestOf(const Reconstruction& reconstruction);

// 16 more for how it is ingested: the placement and the options that change the result of an
// ingest.
std::string DigestOf(const Sim3d& ecef_from_world, const IngestOptions& options);

// Returns true if the sessions hold the same reconstruction, however each was placed and ingested.
bool AreOneRecording(const SessionRecord& a, const SessionRecord& b);

// Throws Error(kConflict) if one of `sessions` has another name than `session` and the same
// content, unless the session is kept apart.
void RequireNotElsewhere(const SessionRecord& session, SessionJoining joining,
                         const std::vector<SessionRecord>& sessions);

}  // namespace cairn

#endif  // CAIRN_INGEST_SESSION_DIGEST_H_
