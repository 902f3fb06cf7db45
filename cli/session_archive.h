// The archive of `cairn ingest --archive`, and what `cairn rebuild` reads from it.
#ifndef CAIRN_CLI_SESSION_ARCHIVE_H_
#define CAIRN_CLI_SESSION_ARCHIVE_H_

#include <string>
#include <vector>

#include "cli/options/cairn_options.h"
#include "core/rigid3.h"
#include "ingest/maps/archive_folder.h"
#include "ingest/plan_session.h"
#include "storage/map/map_store.h"

namespace cairn {

// Archives one session while it is ingested.
class SessionArchive {
 public:
  // Opens the folder, locks it and finishes what a killed ingest left there. Throws as
  // ArchiveFolder and ArchiveFolder::Recover.
  SessionArchive(const std::string& path, const std::string& session_name, const MapStore& map);

  // Stage appends to `paths`, which outlives this object, the name that its file gets by Commit.
  void ListFilesIn(std::vector<std::string>* paths) { paths_ = paths; }

  // Call it before the session is published. Writes the session to the disk, unless the archive has
  // it. Of `options`, the section of the ingest counts. Throws Error(kConflict) if the map has the
  // session already, and the archive has a session that the map got later, or the options would
  // give the first session another codebook than the map has.
  void Stage(const PlannedSession& planned, const Sim3d& ecef_from_world,
             const CairnOptions& options);
  // Call it once the map has the session.
  void Commit();

  // Prints the session's file, if one was written, and the sessions that only one of the archive
  // and the map has. Sessions that only the map has keep the archive from being complete.
  void Print(const MapStore& map) const;

 private:
  ArchiveFolder folder_;
  std::vector<std::string>* paths_ = nullptr;
  bool is_staged_ = false;
  std::string file_;
};

// The options with which a session was ingested, as its manifest has them. Throws
// Error(kMapDamaged), naming the file.
IngestOptions IngestOptionsOf(const ArchiveFile& file);

}  // namespace cairn

#endif  // CAIRN_CLI_SESSION_ARCHIVE_H_
