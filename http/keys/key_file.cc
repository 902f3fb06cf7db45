#include "http/keys/key_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <limits.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/logging.h"
#include "core/printable.h"
#include "core/require.h"
#include "core/wire/json_reader.h"

namespace cairn {
namespace {

constexpr char kFormat[] = "cairn api keys";
constexpr int kVersion = 1;
constexpr uint64_t kMaxFileBytes = uint64_t{4} << 20;
constexpr JsonLimits kKeyFileLimits{.max_values = 16 * kMaxKeys, .max_elements = kMaxKeys};
constexpr double kMinRate = 1e-3, kMaxRate = 1e6;
constexpr int64_t kMaxBurst = 1'000'000, kMaxQuota = 1'000'000'000'000;
constexpr mode_t kForOwner = S_IRUSR | S_IWUSR;
constexpr mode_t kForGroup = S_IRGRP;
constexpr mode_t kTooOpen = S_IWGRP | S_IRWXO;

bool IsLabel(std::string_view text) {
  return !text.empty() && text.size() <= kMaxLabelBytes &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
         });
}

KeyRights ReadRights(const JsonReader& json) {
  KeyRights rights;
  for (const JsonReader& name : json.Elements(1, 3)) {
    const std::optional<KeyRight> right = KeyRightFromName(name.String());
    if (!right) {
      name.Fail(fmt::format("is '{}', neither localize, look nor copy", Excerpt(name.String())));
    }
    rights = rights | *right;
  }
  return rights;
}

ApiKey ReadKey(const JsonReader& json) {
  json.RequireOnly({"label", "sha256", "may", "rate", "burst", "quota"});
  const std::optional<KeyHash> hash = HashFromHex(json.At("sha256").String());
  if (!hash) {
    json.At("sha256").Fail("is not 64 hexadecimal digits in lower case");
  }
  ApiKey key{.label = json.At("label").String(), .hash = *hash, .may = ReadRights(json.At("may"))};
  if (const auto rate = json.Find("rate")) {
    key.rate_per_s = rate->Number();
  }
  if (const auto burst = json.Find("burst")) {
    key.burst = burst->Integer(1, kMaxExactInteger);
  }
  if (const auto quota = json.Find("quota")) {
    key.quota_per_day = quota->Integer(1, kMaxExactInteger);
  }
  try {
    key.Validate();
  } catch (const Error& error) {
    json.Fail(error.what());
  }
  return key;
}

void RequireFormat(const JsonReader& json) {
  json.RequireOnly({"format", "version", "keys"});
  if (json.At("format").String() != kFormat) {
    json.At("format").Fail(fmt::format("is not '{}'", kFormat));
  }
  if (json.At("version").Number() != kVersion) {
    json.At("version").Fail(
        fmt::format("is not {}, the version that this program reads", kVersion));
  }
}

[[noreturn]] void ThrowFileError(const std::string& path, const char* what, int error) {
  throw Error(ErrorCode::kIo, fmt::format("{}: cannot {}: {}", path, what, std::strerror(error)));
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { Close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int fd() const { return fd_; }
  bool Close() { return fd_ < 0 || close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

// Opens the file, which it creates if necessary, and locks it. Returns its descriptor. The file at
// the path may have been replaced while the lock was awaited.
int OpenLocked(const std::string& path) {
  while (true) {
    const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kForOwner);
    if (fd < 0) {
      ThrowFileError(path, "open the file of keys", errno);
    }
    const int error = flock(fd, LOCK_EX) == 0 ? 0 : errno;
    struct stat locked {
    }, current{};
    if (error == 0 && fstat(fd, &locked) == 0 && stat(path.c_str(), &current) == 0 &&
        locked.st_ino == current.st_ino && locked.st_dev == current.st_dev) {
      return fd;
    }
    close(fd);
    if (error != 0 && error != EINTR) {
      ThrowFileError(path, "lock the file of keys", error);
    }
  }
}

// Writes a file beside `path`, with its owner, and renames it. (ReplaceFile of core keeps no
// owner.)
void ReplaceKeepingOwner(const std::string& path, const struct stat& old, const std::string& text) {
  std::string temporary = path + ".XXXXXX";
  Descriptor file(mkstemp(temporary.data()));
  if (file.fd() < 0) {
    ThrowFileError(path, "write beside the file of keys", errno);
  }
  [[maybe_unused]] const int ignored = fchown(file.fd(), old.st_uid, old.st_gid);
  const bool is_written =
      fchmod(file.fd(), old.st_mode & (kForOwner | kForGroup)) == 0 &&
      write(file.fd(), text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
      fsync(file.fd()) == 0 && file.Close() && rename(temporary.c_str(), path.c_str()) == 0;
  if (!is_written) {
    const int error = errno;
    unlink(temporary.c_str());
    ThrowFileError(path, "write the file of keys", error);
  }
}

// `mode` is that from before the change.
void WarnIfOthersLost(const std::string& path, mode_t mode) {
  if ((mode & S_IRWXO) != 0) {
    LogWarning(
        "{}: its mode was {:04o} and is {:04o} now; a server that runs as another user needs "
        "'chgrp' "
        "and 'chmod 640' to read it",
        path, mode & 07777, mode & (kForOwner | kForGroup));
  }
}

// The file itself if `path` is a link to it.
std::string ResolvedPath(const std::string& path) {
  char resolved[PATH_MAX];
  return realpath(path.c_str(), resolved) != nullptr ? resolved : path;
}

}  // namespace

void ApiKey::Validate() const {
  RequireOption(IsLabel(label), fmt::format("label '{}' must have 1 to {} letters, digits, '.', "
                                            "'_' and '-'",
                                            Excerpt(label), kMaxLabelBytes));
  RequireOption(!may.empty(), "may must name a right: localize, look or copy");
  if (rate_per_s) {
    RequireWithin("rate", *rate_per_s, kMinRate, kMaxRate);
  }
  if (burst) {
    RequireOption(rate_per_s.has_value(), "burst needs a rate");
    RequireWithin("burst", *burst, 1, kMaxBurst);
  }
  if (quota_per_day) {
    RequireWithin("quota", *quota_per_day, 1, kMaxQuota);
  }
}

double ApiKey::Burst() const {
  return burst ? static_cast<double>(*burst) : std::max(1.0, std::ceil(rate_per_s.value_or(0.0)));
}

std::vector<ApiKey> ParseKeys(std::string_view text) {
  const JsonDocument document = ParseJson(text, kKeyFileLimits);
  const JsonReader json(document);
  RequireFormat(json);
  std::vector<ApiKey> keys;
  std::set<std::string> labels;
  std::set<KeyHash> hashes;
  for (const JsonReader& element : json.At("keys").Elements(0, kMaxKeys)) {
    const ApiKey& key = keys.emplace_back(ReadKey(element));
    if (!labels.insert(key.label).second) {
      element.At("label").Fail(fmt::format("'{}' is the label of two keys", key.label));
    }
    if (!hashes.insert(key.hash).second) {
      element.At("sha256").Fail("belongs to two labels");
    }
  }
  return keys;
}

std::string KeysAsText(const std::vector<ApiKey>& keys) {
  std::string text =
      fmt::format("{{\n \"format\": \"{}\",\n \"version\": {},\n \"keys\": [", kFormat, kVersion);
  const char* separator = "\n";
  for (const ApiKey& key : keys) {
    nlohmann::ordered_json json = {{"label", key.label}, {"sha256", HexOf(key.hash)}};
    json["may"] = nlohmann::ordered_json::parse("[\"" + NamesOf(key.may, "\",\"") + "\"]");
    if (key.rate_per_s) {
      json["rate"] = *key.rate_per_s;
    }
    if (key.burst) {
      json["burst"] = *key.burst;
    }
    if (key.quota_per_day) {
      json["quota"] = *key.quota_per_day;
    }
    text += std::exchange(separator, ",\n") + ("  " + json.dump());
  }
  return text + (keys.empty() ? "]\n}\n" : "\n ]\n}\n");
}

std::vector<ApiKey> ReadKeyFile(const std::string& path) {
  struct stat info {};
  const bool exists = stat(path.c_str(), &info) == 0;
  if (exists && !S_ISREG(info.st_mode)) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{}: is no regular file; a pipe, as <(...) is one, cannot be read again "
                    "after SIGHUP",
                    path));
  }
  const std::string text = ReadTextFile(path, kMaxFileBytes);
  if (exists && (info.st_mode & kTooOpen) != 0) {
    LogWarning(
        "{}: the mode of the file of API keys is {:04o}: others may read or change it; 'chmod 600' "
        "mends that",
        path, info.st_mode & 07777);
  }
  try {
    return ParseKeys(text);
  } catch (const Error& error) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: {}; 'cairn keys new' writes such a file", path, error.what()));
  }
}

void ChangeKeyFile(const std::string& path,
                   const std::function<void(std::vector<ApiKey>* keys)>& change) {
  const std::string resolved = ResolvedPath(path);
  const bool existed = access(resolved.c_str(), F_OK) == 0;
  const Descriptor locked(OpenLocked(resolved));
  struct stat info {};
  if (fstat(locked.fd(), &info) != 0 || !S_ISREG(info.st_mode)) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: is no regular file", path));
  }
  try {
    std::vector<ApiKey> keys;
    if (info.st_size > 0) {
      keys = ReadKeyFile(resolved);
    }
    change(&keys);
    ReplaceKeepingOwner(resolved, info, KeysAsText(keys));
    WarnIfOthersLost(path, info.st_mode);
  } catch (...) {
    if (!existed && info.st_size == 0) {
      unlink(resolved.c_str());
    }
    throw;
  }
}

}  // namespace cairn
