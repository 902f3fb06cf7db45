// The folder in which `cairn ingest --archive` keeps sessions: docs/formats/archive_v1.md.
#ifndef CAIRN_INGEST_MAPS_ARCHIVE_FOLDER_H_
#define CAIRN_INGEST_MAPS_ARCHIVE_FOLDER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "ingest/maps/archived_session.h"

namespace cairn {

struct ArchiveFile {
  std::string path;
  int64_t number = 0;  // The place of the session in the order of ingest.
  ArchiveManifest manifest;
};

// A session that a map has.
struct MapSession {
  SessionKey key;
  SessionId id{};
};

// The traits that tell the map of an archive from other maps.
struct ArchivedMap {
  std::string
      created_at;  // MapInfo::created_at. Copies of the map have the same, rebuilt ones not.
  MapVersion version{};
  std::vector<MapSession> sessions;
};

// An open folder. Locks it against other processes until the end of the object's life.
class ArchiveFolder {
 public:
  enum class Use {
    kIngest,   // Nobody else uses the folder.
    kRebuild,  // Others may rebuild, too.
  };

  // Reads the manifests of all sessions. An ingest makes the folder if the one above it exists.
  // Throws Error(kNotFound) if there is no such folder, Error(kBadInput) if it is not an archive or
  // has two files of one number, Error(kConflict) if another process uses it, Error(kMapDamaged) if
  // a manifest is damaged, and Error(kIo) if the folder cannot be read or, for an ingest, written.
  ArchiveFolder(const std::string& path, Use use);
  // Leaves a staged file that was not committed to Recover: the map may have got the session.
  ~ArchiveFolder();
  ArchiveFolder(const ArchiveFolder&) = delete;
  ArchiveFolder& operator=(const ArchiveFolder&) = delete;

  const std::string& path() const { return path_; }
  const std::vector<ArchiveFile>& files() const { return files_; }  // Ordered by number.
  // Files that a running or killed ingest left.
  const std::vector<std::string>& unfinished() const { return unfinished_; }
  bool Holds(const SessionKey& session) const;

  // Finishes what an ingest left that failed or was killed. An unfinished file gets its name if the
  // map has the session from that very ingest, which its id tells; else it goes. Older files of
  // sessions that were replaced go, too.
  //
  // Changes nothing and throws
  //  - Error(kConflict) if the archive is of another map: the map was created at another time than
  //    the one that got the newest file and lacks a session, it has another session of the same
  //    name, or an unfinished file is of an ingest into another map. The session `incoming` may
  //    differ; it is about to be replaced;
  //  - Error(kMapDamaged) if an unfinished file is damaged and not just cut off;
  //  - Error(kIo) if one cannot be read.
  void Recover(const ArchivedMap& map, const std::string& incoming);

  // Writes a session to the disk under a temporary name. Call it right before the session is
  // published. Throws Error(kIo), and leaves no file then.
  void Stage(const ArchiveManifest& manifest, const Reconstruction& reconstruction);
  // Call it once the map has the staged session: gives the file its name and deletes older files of
  // the session. Returns the file's path. Throws Error(kIo).
  std::string Commit();

 private:
  void Lock(Use use);
  void ReadNames();
  void ReadName(const std::string& file);
  // Deletes files of the session's name that are older than the newest with its content.
  void DeleteReplaced(const SessionKey& session);

  std::string path_;
  int folder_fd_ = -1;
  std::vector<ArchiveFile> files_;
  std::vector<std::string> unfinished_;
  std::string staged_;  // The name that the staged file will have; empty if there is none.
};

// Deletes files that ingests into a map wrote, finished or not; for a map that was not made after
// all. `paths` are those of the finished files. Does not fail.
void DeleteArchived(const std::vector<std::string>& paths);

// Reads a session. Throws Error(kMapDamaged), and Error(kIo) if the file cannot be read.
ArchivedSession ReadArchivedSession(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_ARCHIVE_FOLDER_H_
