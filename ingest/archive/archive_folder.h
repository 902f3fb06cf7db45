// The folder in which `cairn ingest --archive` keeps sessions: docs/formats/archive_v1.md.
#ifndef CAIRN_INGEST_ARCHIVE_ARCHIVE_FOLDER_H_
#define CAIRN_INGEST_ARCHIVE_ARCHIVE_FOLDER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "ingest/archive/archived_session.h"

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

// An open folder. Locks it against other processes until the end of the object's life.
class ArchiveFolder {
 public:
  enum class Use {
    kIngest,   // Nobody else uses the folder.
    kRebuild,  // Others may rebuild, too.
  };

  // Reads the manifests of all sessions. Throws Error(kNotFound) if there is no such folder,
  // Error(kBadInput) if it is none or has two files of one number, Error(kConflict) if another
  // process uses it, Error(kMapDamaged) if a manifest is damaged, and Error(kIo) if the folder
  // cannot be read or, for an ingest, written.
  ArchiveFolder(const std::string& path, Use use);
  ~ArchiveFolder();  // Deletes what was staged and not committed.
  ArchiveFolder(const ArchiveFolder&) = delete;
  ArchiveFolder& operator=(const ArchiveFolder&) = delete;

  const std::string& path() const { return path_; }
  const std::vector<ArchiveFile>& files() const { return files_; }  // Ordered by number.
  // Files that a running or killed ingest left.
  const std::vector<std::string>& unfinished() const { return unfinished_; }
  bool Holds(const SessionKey& session) const;

  // Finishes what a killed ingest left. An unfinished file gets its name if the map has the session
  // from that very ingest, which its id tells; else it goes. Files of sessions that were replaced
  // go, too. `sessions` are those of the map.
  void Recover(const std::vector<MapSession>& sessions);

  // Throws Error(kConflict) if the archive is of another map than the one of `sessions`: it has
  // none of them, or one with other content. The session `incoming` may differ; it is about to be
  // replaced.
  void RequireOf(const std::vector<MapSession>& sessions, const std::string& incoming) const;

  // Writes a session to the disk under a temporary name. Throws Error(kIo).
  void Stage(const ArchiveManifest& manifest, const Reconstruction& reconstruction);
  // Call it once the map has the staged session: gives the file its name and deletes older files of
  // the session. Returns the file's path. Throws Error(kIo).
  std::string Commit();

 private:
  void Lock(Use use);
  void ReadNames();
  // Deletes files of the session's name but for the newest with its content, if there is one.
  void DeleteReplaced(const SessionKey& session);

  std::string path_;
  int folder_fd_ = -1;
  std::vector<ArchiveFile> files_;
  std::vector<std::string> unfinished_;
  std::string staged_;  // The name that the staged file will have; empty if there is none.
};

// Reads a session. Throws Error(kMapDamaged), and Error(kIo) if the file cannot be read.
ArchivedSession ReadArchivedSession(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_INGEST_ARCHIVE_ARCHIVE_FOLDER_H_
