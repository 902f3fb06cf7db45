#include "ingest/maps/archive_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "core/shared_folder.h"
#include "ingest/maps/archive_codec.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr char kSuffix[] = ".cairnsession";
constexpr char kUnfinished[] = ".unfinished";

[[noreturn]] void ThrowIo(const std::string& path, const char* what, int error) {
  throw Error(ErrorCode::kIo, fmt::format("{}: {}: {}", path, what, std::strerror(error)));
}

std::ifstream OpenFile(const std::string& path) {
  RequireUnlinkedFile(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    ThrowIo(path, "cannot be read", errno);
  }
  return file;
}

ArchiveManifest ReadManifest(const std::string& path) {
  std::ifstream file = OpenFile(path);
  return DecodeManifest(&file, path);
}

// The manifest of a whole file; nothing if a process died while it wrote the file.
std::optional<ArchiveManifest> ReadIfWhole(const std::string& path) {
  std::ifstream file = OpenFile(path);
  try {
    return DecodeSession(&file, path).manifest;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kMapDamaged) {
      throw;
    }
    if (file.fail()) {  // The file is cut off.
      return std::nullopt;
    }
    throw Error(error.code(), std::string(error.what()) +
                                  "; an ingest did not finish this file: delete it if the map does "
                                  "not have its session");
  }
}

// Nothing if the name is not of an archived session.
std::optional<int64_t> NumberOf(const std::string& name) {
  constexpr size_t kMaxDigits = 12;
  const size_t num_digits = std::min(name.find_first_not_of("0123456789"), name.size());
  if (num_digits == 0 || num_digits > kMaxDigits || !name.ends_with(kSuffix)) {
    return std::nullopt;
  }
  return std::stoll(name.substr(0, num_digits));
}

std::string FileName(int64_t number, const std::string& session_name) {
  constexpr size_t kMaxNameBytes = 60;
  std::string readable = session_name.substr(0, kMaxNameBytes);
  std::ranges::replace_if(
      readable,
      [](unsigned char c) {
        return c >= 0x80 || (std::isalnum(c) == 0 && std::strchr("._-", c) == nullptr);
      },
      '_');
  return fmt::format("{:04}-{}{}", number, readable, kSuffix);
}

// A new file, which replaces a file or a link of the name; every failure to write is an Error(kIo).
class OutputFile {
 public:
  explicit OutputFile(std::string path) : path_(std::move(path)) {
    unlink(path_.c_str());
    // O_EXCL does not follow a link that somebody makes meanwhile.
    fd_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (fd_ < 0) {
      ThrowIo(path_, "cannot be created", errno);
    }
  }
  ~OutputFile() { close(fd_); }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void Write(std::span<const uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = write(fd_, bytes.data(), bytes.size());
      if (written < 0 && errno != EINTR) {
        ThrowIo(path_, "cannot be written", errno);
      }
      bytes = bytes.subspan(static_cast<size_t>(std::max<ssize_t>(written, 0)));
    }
  }
  void Sync() {
    if (fsync(fd_) != 0) {
      ThrowIo(path_, "cannot be written", errno);
    }
  }

 private:
  std::string path_;
  int fd_ = -1;
};

void Rename(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) {
    ThrowIo(to, "cannot get its name", errno);
  }
}

void Write(const std::string& path, const ArchiveManifest& manifest,
           const Reconstruction& reconstruction) {
  OutputFile file(path);
  EncodeSession(manifest, reconstruction,
                [&](std::span<const uint8_t> bytes) { file.Write(bytes); });
  file.Sync();
}

// Leaves no file if it throws.
void WriteOrRemove(const std::string& path, const ArchiveManifest& manifest,
                   const Reconstruction& reconstruction) {
  try {
    Write(path, manifest, reconstruction);
  } catch (...) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw;
  }
}

void Remove(const std::string& path) {
  std::error_code error;
  if (!fs::remove(path, error) && error) {
    ThrowIo(path, "cannot be removed", error.value());
  }
}

// One level, so that a misspelled path makes no folder somewhere. Leaves what is there.
void MakeIfMissing(const std::string& path) {
  if (mkdir(path.c_str(), 0777) == 0 || errno == EEXIST) {
    return;
  }
  if (errno == ENOENT) {
    throw Error(ErrorCode::kNotFound,
                path + ": the folder above this one does not exist; make it with mkdir");
  }
  ThrowIo(path, "cannot be made", errno);
}

bool IsPublished(const ArchiveManifest& manifest, const std::vector<MapSession>& sessions) {
  return std::ranges::any_of(sessions, [&](const MapSession& session) {
    return session.key == manifest.session && session.id == manifest.first_ids.session;
  });
}

// What becomes of an unfinished file: a file if the map has its session, else nothing.
std::optional<ArchiveFile> FinishedFile(const std::string& unfinished, const ArchivedMap& map) {
  const std::optional<ArchiveManifest> manifest = ReadIfWhole(unfinished);
  if (!manifest) {
    return std::nullopt;
  }
  if (manifest->map_created_at != map.created_at) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: an ingest into another map, created at {}, did not finish this "
                            "file; ingest into that map with this archive, or delete the file if "
                            "that map is gone",
                            unfinished, manifest->map_created_at));
  }
  if (!IsPublished(*manifest, map.sessions)) {
    return std::nullopt;
  }
  const std::string path = unfinished.substr(0, unfinished.size() - std::strlen(kUnfinished));
  return ArchiveFile{path, NumberOf(fs::path(path).filename().string()).value(), *manifest};
}

// True if a newer file has what the map has under the name of the file's session.
bool IsReplaced(const ArchiveFile& file, const SessionKey& in_map,
                const std::vector<ArchiveFile>& files) {
  return std::ranges::any_of(files, [&](const ArchiveFile& other) {
    return other.manifest.session == in_map && other.number > file.number;
  });
}

[[noreturn]] void RefuseOtherMap(const std::string& problem) {
  throw Error(ErrorCode::kConflict,
              problem + "; an archive belongs to one map: give each map a folder of its own");
}

// True if the map got the newest file. A map of version 1 never got a session, though another map
// may have been created in the same second.
bool IsOwner(const ArchivedMap& map, const std::vector<ArchiveFile>& files) {
  return files.back().manifest.map_created_at == map.created_at && map.version > MapVersion(1);
}

void RequireOf(const std::vector<ArchiveFile>& files, const ArchivedMap& map,
               const std::string& incoming) {
  for (const ArchiveFile& file : files) {
    const SessionKey& key = file.manifest.session;
    const auto same = std::ranges::find_if(
        map.sessions, [&](const MapSession& session) { return session.key.name == key.name; });
    if (same == map.sessions.end()) {
      if (!IsOwner(map, files)) {
        RefuseOtherMap(fmt::format(
            "{}: the file belongs to a map created at {}. The map, created at {}, lacks session "
            "'{}'. If the map was rebuilt without the session, delete the file",
            file.path, file.manifest.map_created_at, map.created_at, Excerpt(key.name)));
      }
    } else if (key.name != incoming && same->key != key && !IsReplaced(file, same->key, files)) {
      RefuseOtherMap(fmt::format(
          "{}: the map has another session '{}' than this file; if it was replaced without "
          "--archive, delete the file and ingest the session again with --archive",
          file.path, Excerpt(key.name)));
    }
  }
}

}  // namespace

ArchiveFolder::ArchiveFolder(const std::string& path, Use use) : path_(path) {
  if (use == Use::kIngest) {
    MakeIfMissing(path);
  }
  folder_fd_ = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_fd_ < 0) {
    if (errno == ENOENT) {
      throw Error(ErrorCode::kNotFound, path + ": there is no such folder");
    }
    if (errno == ENOTDIR) {
      throw Error(ErrorCode::kBadInput, path + ": an archive is a folder, and this is a file");
    }
    ThrowIo(path, "cannot be read", errno);
  }
  try {
    Lock(use);
    ReadNames();
  } catch (...) {
    close(folder_fd_);
    throw;
  }
}

ArchiveFolder::~ArchiveFolder() { close(folder_fd_); }

void ArchiveFolder::Lock(Use use) {
  const int kind = use == Use::kIngest ? LOCK_EX : LOCK_SH;
  // Some network file systems have no such locks. There, users must not run two ingests at once.
  if (flock(folder_fd_, kind | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw Error(ErrorCode::kConflict, path_ + ": another process uses this archive");
  }
  if (use == Use::kIngest && access(path_.c_str(), W_OK) != 0) {
    ThrowIo(path_, "cannot be written", errno);
  }
}

void ArchiveFolder::ReadName(const std::string& file) {
  constexpr size_t kUnfinishedSize = sizeof(kUnfinished) - 1;
  const std::string name = fs::path(file).filename().string();
  if (const std::optional<int64_t> number = NumberOf(name)) {
    files_.push_back({file, *number, ReadManifest(file)});
  } else if (name.ends_with(kUnfinished) &&
             NumberOf(name.substr(0, name.size() - kUnfinishedSize))) {
    unfinished_.push_back(file);
  }
}

void ArchiveFolder::ReadNames() {
  std::error_code error;
  for (fs::directory_iterator entry(path_, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    ReadName(entry->path().string());
  }
  if (error) {
    ThrowIo(path_, "cannot be read", error.value());
  }
  std::ranges::sort(unfinished_);
  std::ranges::sort(files_, {}, &ArchiveFile::number);
  const auto same = std::ranges::adjacent_find(files_, {}, &ArchiveFile::number);
  if (same != files_.end()) {
    throw Error(ErrorCode::kBadInput, fmt::format("{} and {} have one number; rename one of them",
                                                  same->path, std::next(same)->path));
  }
}

bool ArchiveFolder::Holds(const SessionKey& session) const {
  return std::ranges::any_of(
      files_, [&](const ArchiveFile& file) { return file.manifest.session == session; });
}

void ArchiveFolder::Recover(const ArchivedMap& map, const std::string& incoming) {
  std::vector<ArchiveFile> files = files_;
  std::vector<std::string> lost;
  for (const std::string& unfinished : unfinished_) {
    if (std::optional<ArchiveFile> file = FinishedFile(unfinished, map)) {
      files.push_back(*std::move(file));
    } else {
      lost.push_back(unfinished);
    }
  }
  std::ranges::sort(files, {}, &ArchiveFile::number);
  RequireOf(files, map, incoming);
  for (const std::string& unfinished : std::exchange(unfinished_, {})) {
    if (std::ranges::count(lost, unfinished) > 0) {
      Remove(unfinished);
    } else {
      Rename(unfinished, unfinished.substr(0, unfinished.size() - std::strlen(kUnfinished)));
    }
  }
  files_ = std::move(files);
  for (const MapSession& session : map.sessions) {
    DeleteReplaced(session.key);
  }
}

void ArchiveFolder::Stage(const ArchiveManifest& manifest, const Reconstruction& reconstruction) {
  const int64_t number = files_.empty() ? 1 : files_.back().number + 1;
  const std::string path = (fs::path(path_) / FileName(number, manifest.session.name)).string();
  WriteOrRemove(path + kUnfinished, manifest, reconstruction);
  fsync(folder_fd_);
  staged_ = path;
  files_.push_back({path, number, manifest});
}

std::string ArchiveFolder::Commit() {
  const std::string path = std::exchange(staged_, "");
  Rename(path + kUnfinished, path);
  DeleteReplaced(files_.back().manifest.session);
  fsync(folder_fd_);
  return path;
}

void ArchiveFolder::DeleteReplaced(const SessionKey& session) {
  const auto newest = std::find_if(files_.rbegin(), files_.rend(), [&](const ArchiveFile& file) {
    return file.manifest.session == session;
  });
  if (newest == files_.rend()) {
    return;
  }
  std::erase_if(files_, [&, kept = newest->number](const ArchiveFile& file) {
    const bool is_replaced = file.manifest.session.name == session.name && file.number < kept;
    if (is_replaced) {
      Remove(file.path);
    }
    return is_replaced;
  });
}

void DeleteArchived(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    std::error_code ignored;
    fs::remove(path, ignored);
    fs::remove(path + kUnfinished, ignored);
  }
}

ArchivedSession ReadArchivedSession(const std::string& path) {
  std::ifstream file = OpenFile(path);
  return DecodeSession(&file, path);
}

}  // namespace cairn
