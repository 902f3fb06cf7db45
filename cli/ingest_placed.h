// Ingests a reconstruction that has its place on Earth, and archives it.
#ifndef CAIRN_CLI_INGEST_PLACED_H_
#define CAIRN_CLI_INGEST_PLACED_H_

#include <memory>
#include <string>

#include "cli/options/cairn_options.h"
#include "cli/session_archive.h"
#include "cli/session_arguments.h"
#include "ingest/ingest_report.h"
#include "ingest/session_plan.h"
#include "storage/map/map_store.h"

namespace cairn {

// Returns null if `path`, the value of --archive, is empty.
std::unique_ptr<SessionArchive> OpenSessionArchive(const std::string& path,
                                                   const std::string& session_name,
                                                   const MapStore& store);

// Ingests the session with its own options and, unless `archive` is null, archives it.
IngestReport IngestPlaced(const PlacedReconstruction& session, CairnOptions options,
                          SessionArchive* archive, const IngestProgress& progress, MapStore* store);

}  // namespace cairn

#endif  // CAIRN_CLI_INGEST_PLACED_H_
