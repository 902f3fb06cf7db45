// The sessions of `cairn map`: which of them the map takes, and in which order.
#ifndef CAIRN_CLI_PUBLISH_IN_TURN_H_
#define CAIRN_CLI_PUBLISH_IN_TURN_H_

#include <functional>
#include <string>
#include <vector>

#include "cli/session_arguments.h"
#include "ingest/ingest_report.h"
#include "mapping/session/map_photos.h"

namespace cairn {

// A session of photos, and what became of it.
struct MapSessionResult {
  std::string name;
  bool is_mapped = false;        // The photos became a model, or segments that a map may place.
  MappedPhotos mapped;           // Without its model, which is in `session`.
  PlacedReconstruction session;  // As it was published.
  bool is_in_map = false;
  std::string problem;  // Why it is not; else empty.
  IngestReport report;  // If it is.
};

// Publishes the `session` of a result with its options. May write into `session` and `mapped` what
// became of its parts. Throws as IngestSession.
using PublishOne = std::function<IngestReport(MapSessionResult* result)>;

// Sorts the sessions, most mapped photos first, then by name: what follows does not depend on the
// order in which they were named.
void SortSessions(std::vector<MapSessionResult>* sessions);

// Publishes the mapped sessions one after the other, until none is left that the map takes. The
// first one that is anchored in what the map has is next; if none is (`map_is_empty` says that
// there is nothing yet), the first one that may stand by its positions. So a session that reaches
// over new ground waits for those that connect it. A session that the map refuses
// (SessionRefused) is tried again when the map has grown, and else keeps the refusal as its
// problem. A session that is alone is tried once, and its refusal thrown. If no session is
// published, throws Error with the problems of all: kConflict if the map refused one
// that has a place, else kBadInput.
void PublishInTurn(const PublishOne& publish, bool map_is_empty,
                   std::vector<MapSessionResult>* sessions);

}  // namespace cairn

#endif  // CAIRN_CLI_PUBLISH_IN_TURN_H_
