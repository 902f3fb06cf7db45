// Which sessions of an archive make a map.
#ifndef CAIRN_INGEST_MAPS_REBUILD_PLAN_H_
#define CAIRN_INGEST_MAPS_REBUILD_PLAN_H_

#include <string>
#include <vector>

#include "ingest/maps/archive_folder.h"

namespace cairn {

// Returns the files to ingest, in order: all of the archive but those of the sessions `without`.
// Throws
//  - Error(kNotFound) if the archive lacks a session of `without`, or one that the map had when a
//    later session was ingested;
//  - Error(kConflict) if an ingest was killed, two files are of one session, or sessions differ in
//    their descriptors;
//  - Error(kBadInput) if nothing is left.
std::vector<ArchiveFile> PlanRebuild(const ArchiveFolder& archive,
                                     const std::vector<std::string>& without);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_REBUILD_PLAN_H_
