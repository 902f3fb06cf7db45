// The file of API keys (docs/formats/api_keys_v1.md).
#ifndef CAIRN_HTTP_KEYS_KEY_FILE_H_
#define CAIRN_HTTP_KEYS_KEY_FILE_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "http/keys/key_rights.h"
#include "http/keys/secret.h"

namespace cairn {

// In one file.
inline constexpr size_t kMaxKeys = 4096;
inline constexpr size_t kMaxLabelBytes = 64;

// One key, without its secret.
struct ApiKey {
  std::string label;  // Whose it is: letters, digits, '.', '_', '-'. Unique in a file.
  KeyHash hash{};     // HashOfSecret of the secret. Unique in a file.
  KeyRights may;
  // Requests a second, on average. Nothing: as many as the server can answer.
  std::optional<double> rate_per_s = std::nullopt;
  // Requests that may come at once after a pause. Nothing: those of a second, at least one. Only
  // with a rate.
  std::optional<int64_t> burst = std::nullopt;
  // Requests a day, which begins at midnight UTC. Nothing: no limit.
  std::optional<int64_t> quota_per_day = std::nullopt;

  // Throws Error(kInvalidArgument) that names the field and its limits.
  void Validate() const;
  double Burst() const;  // With its default. Only with a rate.
};

// Reads the text of a file. Throws Error(kBadInput) that names the member at fault.
std::vector<ApiKey> ParseKeys(std::string_view text);
// One key a line. ParseKeys reads it back.
std::string KeysAsText(const std::vector<ApiKey>& keys);

// Reads a file. Throws as ReadTextFile, and Error(kBadInput) that names the file and the member.
// Refuses what is no regular file: a pipe without a writer would hold up the caller.
// Logs a warning if others than the owner and its group may read the file, or others than the owner
// may write to it.
std::vector<ApiKey> ReadKeyFile(const std::string& path);

// Lets `change` change the keys of a file and writes the file anew, in one step, so that a server
// never reads half of it. A missing file counts as one without keys, and a new one may be read by
// its owner only. Logs a warning if the change takes rights of others. Calls at the same time wait
// for each other. Throws as ReadKeyFile and as `change`, and then leaves the file as it was; throws
// Error(kIo) if the file cannot be written.
void ChangeKeyFile(const std::string& path,
                   const std::function<void(std::vector<ApiKey>* keys)>& change);

}  // namespace cairn

#endif  // CAIRN_HTTP_KEYS_KEY_FILE_H_
