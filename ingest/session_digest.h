// Tells sessions of the same photos apart from others. Private to ingest.
#ifndef CAIRN_INGEST_SESSION_DIGEST_H_
#define CAIRN_INGEST_SESSION_DIGEST_H_

#include <string>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "ingest/ingest_options.h"
#include "storage/map/map_store.h"

namespace cairn {

// 32 hexadecimal digits of XXH3: what the reconstruction holds. The order of its images and
// landmarks counts.
std::string DigestOf(const Reconstruction& reconstruction);

// 16 more for how it is ingested: the placement and the options that change the result of an
// ingest.
std::string DigestOf(const Sim3d& ecef_from_world, const IngestOptions& options);

// At most 8,192 more for its photos: 8 digits each for the descriptors of a photo, ascending, of
// the 1,024 photos with the smallest digits. Equal photos have equal digits, whatever their names
// and the model are, and a map needs no column more. Two photos that differ share their digits once
// in four billion pairs.
std::string PhotosDigestOf(const Reconstruction& reconstruction);

// Returns true if the content digests are of the same reconstruction, ingested in the same way. The
// photos do not count, because digests of older maps lack them.
bool AreOneIngest(const std::string& digest_a, const std::string& digest_b);

// The part of the session's digest that AreOneIngest compares, which archives keep.
std::string IngestDigestOf(const SessionRecord& session);

// How many of the photos of `session` the session `other` has, too. Of large sessions, a sample is
// compared. Compares nothing if one of the digests has no photos.
struct SharedPhotos {
  int num_shared = 0;
  int num_compared = 0;
};
SharedPhotos CountSharedPhotos(const SessionRecord& session, const SessionRecord& other);

// Returns true if the photos that the sessions share are too few to count twice.
bool AreMostlyNew(const SharedPhotos& shared);

// Returns true if the sessions hold the same reconstruction, however each was placed and ingested.
bool AreOneRecording(const SessionRecord& a, const SessionRecord& b);

// Throws SessionRefused if one of `sessions` has another name than `session` and the same content
// or many of its photos, unless the session is kept apart.
void RequireNotElsewhere(const SessionRecord& session, SessionJoining joining,
                         const std::vector<SessionRecord>& sessions);

// Logs which of the sessions with other names have some of the photos, too.
void WarnOfSharedPhotos(const SessionRecord& session, const std::vector<SessionRecord>& sessions);

}  // namespace cairn

#endif  // CAIRN_INGEST_SESSION_DIGEST_H_
