#include "mapping/work_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "core/check.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "core/printable.h"
#include "core/replace_file.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/checksum.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array<char, 8> kMagic = {'C', 'A', 'I', 'R', 'N', 'M', 'W', '2'};
constexpr size_t kChecksumAt = kMagic.size();
constexpr uint64_t kMaxBytes = uint64_t{1} << 33;

[[noreturn]] void ThrowIo(const std::string& path, const std::string& reason) {
  throw Error(ErrorCode::kIo, fmt::format("{}: {}", Printable(path), reason));
}

// How the names of the files begin that a run writes: the stages' results, and the report. People
// may keep other files in the folder.
constexpr std::array<std::string_view, 13> kOwnPrefixes = {
    "photo-",   "views-",     "focal-",    "again-",    "grown-",      "regrown-",   "pairs.",
    "cameras.", "corrected.", "segments.", "adjusted-", "report.svg.", "report.png."};

bool HasOwnPrefix(const std::string& name) {
  return std::any_of(kOwnPrefixes.begin(), kOwnPrefixes.end(),
                     [&](std::string_view prefix) { return name.starts_with(prefix); });
}

bool IsOwnUnfinished(const fs::path& path) {
  return path.extension() == kUnfinishedSuffix && HasOwnPrefix(path.filename().string());
}

void RemoveUnfinished(const std::string& path) {
  std::error_code error;
  fs::directory_iterator entry(path, error), end;
  for (; !error && entry != end; entry.increment(error)) {
    if (IsOwnUnfinished(entry->path())) {
      std::error_code ignored;
      fs::remove(entry->path(), ignored);
    }
  }
}

}  // namespace

WorkFolder::WorkFolder(const std::string& path) : path_(path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) {
    ThrowIo(path, error.message());
  }
  lock_fd_ = open(PathOf("lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (lock_fd_ < 0) {
    ThrowIo(PathOf("lock"), std::strerror(errno));
  }
  if (flock(lock_fd_, LOCK_EX | LOCK_NB) != 0) {
    close(lock_fd_);
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: another run uses this work folder; wait for it, or give another "
                            "folder",
                            Printable(path)));
  }
  RemoveUnfinished(path);
}

WorkFolder::~WorkFolder() { close(lock_fd_); }

std::optional<std::vector<uint8_t>> WorkFolder::Load(const std::string& name,
                                                     const std::string& key) const {
  std::error_code error;
  if (!fs::is_regular_file(PathOf(name), error)) {
    return std::nullopt;
  }
  std::vector<uint8_t> bytes = ReadFileBytes(PathOf(name), kMaxBytes);
  const size_t header = kChecksumAt + sizeof(uint64_t) + sizeof(uint32_t);
  if (bytes.size() < header || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    return std::nullopt;
  }
  ByteReader reader(bytes, name);
  reader.Take(kChecksumAt);
  const uint64_t checksum = reader.Get<uint64_t>();
  const uint32_t key_size = reader.Get<uint32_t>();
  if (checksum != ChecksumOf(bytes, kChecksumAt) || key_size != key.size() ||
      reader.remaining() < key.size() ||
      std::memcmp(reader.Take(key.size()).data(), key.data(), key.size()) != 0) {
    return std::nullopt;
  }
  bytes.erase(bytes.begin(), bytes.end() - static_cast<std::ptrdiff_t>(reader.remaining()));
  return bytes;
}

void WorkFolder::Store(const std::string& name, const std::string& key,
                       std::span<const uint8_t> bytes) const {
  CAIRN_CHECK(HasOwnPrefix(name + "."), "nobody would remove an unfinished file of this name");
  std::vector<uint8_t> file;
  file.reserve(bytes.size() + key.size() + 32);
  ByteWriter writer(&file);
  writer.PutArray(std::span<const char>(kMagic));
  writer.Put<uint64_t>(0);
  writer.Put<uint32_t>(static_cast<uint32_t>(key.size()));
  writer.PutArray(std::span<const char>(key));
  writer.PutArray(bytes);
  const uint64_t checksum = ChecksumOf(file, kChecksumAt);
  std::memcpy(file.data() + kChecksumAt, &checksum, sizeof(checksum));
  ReplaceFile(PathOf(name), file);
}

}  // namespace cairn
