// All of `cairn map` but its arguments and what it prints.
#ifndef CAIRN_CLI_MAP_SESSION_H_
#define CAIRN_CLI_MAP_SESSION_H_

#include <string>
#include <vector>

#include "cli/publish_in_turn.h"
#include "cli/session_arguments.h"
#include "ingest/session_plan.h"
#include "mapping/session/map_photos.h"

namespace cairn {

struct MapSessionArguments {
  SessionArguments session;  // Without a reconstruction.
  MapPhotosInput input;      // The threads are those of the ingest's options.
  std::string archive_path;  // Empty: no archive.
};

// Maps the photos and publishes them as one session of the map, which is made if there is none yet:
// then there is all of it or nothing. What would refuse the result is looked for before the long
// work. If `progress` throws, the map is as before. Throws as MapPhotos, IngestSession and
// CheckReplacement; Error(kIo) if the map cannot be made.
MapSessionResult MakeMapSession(MapSessionArguments arguments, const IngestProgress& progress);

// If `arguments` has no session name and several paths, all of them folders, each folder is a
// session of its name; otherwise as MakeMapSession. Folders are mapped each by itself, by work
// folders of their names within that of `arguments`, and join the map in turn (PublishInTurn), so
// their order does not matter. A folder that makes no model, and a session that the map refuses,
// have a problem, and the others go on. A map that is made has all the other sessions or nothing;
// a map that was there gets a version for each. Keeps the models of all folders in memory. Throws
// Error(kInvalidArgument) if two folders have one name; as MakeMapSession for what is no folder's
// fault, with the names of the sessions that the map got before.
std::vector<MapSessionResult> MakeMapSessions(const MapSessionArguments& arguments,
                                              const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_CLI_MAP_SESSION_H_
