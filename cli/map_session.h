// All of `cairn map` but its arguments and what it prints.
#ifndef CAIRN_CLI_MAP_SESSION_H_
#define CAIRN_CLI_MAP_SESSION_H_

#include <string>

#include "cli/session_arguments.h"
#include "ingest/ingest_report.h"
#include "ingest/session_plan.h"
#include "mapping/session/map_photos.h"

namespace cairn {

struct MapSessionArguments {
  SessionArguments session;  // Without a reconstruction.
  MapPhotosInput input;      // The threads are those of the ingest's options.
  std::string archive_path;  // Empty: no archive.
};

struct MapSessionResult {
  MappedPhotos mapped;           // Without its model, which is in `session`.
  PlacedReconstruction session;  // As it was published.
  IngestReport report;
};

// Maps the photos and publishes them as a session of the map, which is made if there is none yet:
// then there is all of it or nothing. What would refuse the result is looked for before the long
// work. If `progress` throws, the map is as before. Throws as MapPhotos, IngestSession and
// CheckReplacement; Error(kIo) if the map cannot be made.
MapSessionResult MakeMapSession(MapSessionArguments arguments, const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_CLI_MAP_SESSION_H_
