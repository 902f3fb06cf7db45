// The keys of a running server, and what their holders have used.
#ifndef CAIRN_HTTP_KEYS_KEY_RING_H_
#define CAIRN_HTTP_KEYS_KEY_RING_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "http/keys/key_file.h"

namespace cairn {

// Finds the key of a request and counts its requests. Use is counted in memory: a restarted server
// begins anew, and each of several servers counts what it sees.
//
// The hash of what a client presents is looked up under a salted hash, whose salt is random and
// leaves the process never. So the time of a search says nothing about the stored hashes, and the
// last comparison takes the same time for all keys.
//
// Safe to call from any thread.
class KeyRing {
 public:
  struct Now {
    std::chrono::steady_clock::time_point steady;  // For the rate.
    int64_t unix_s = 0;                            // For the day of the quota.
  };
  // Who sent a request.
  struct Holder {
    ApiKey key;
    uint64_t client = 0;  // As HttpRequest::client, for the label of the key.
  };

  explicit KeyRing(const std::vector<ApiKey>& keys) { Replace(keys); }

  // The use of a label that stays is kept.
  void Replace(const std::vector<ApiKey>& keys);

  // Throws HttpError kUnauthorized unless `presented` is a key.
  Holder Identify(const std::optional<std::string>& presented) const;

  // Throws HttpError kForbidden unless the key has one of the `needed` rights.
  static void RequireRight(const Holder& holder, KeyRights needed);

  // Counts a request. Throws HttpError kTooManyRequests with Retry-After if the key has used up its
  // rate or its quota; such a request does not count.
  void Charge(const Holder& holder, const Now& now);

  // Throws as Charge, and counts nothing.
  void CheckUse(const Holder& holder, const Now& now) const;

 private:
  struct Table {
    KeyHash salt;
    std::vector<ApiKey> keys;
    std::unordered_map<uint64_t, size_t> by_salted_hash;  // Indices of `keys`.
  };
  struct Use {
    double tokens = 0.0;  // Requests that may come at once.
    std::optional<std::chrono::steady_clock::time_point> refilled;
    int64_t day = 0;
    int64_t num_requests = 0;  // On that day.
  };

  static std::shared_ptr<const Table> MakeTable(const std::vector<ApiKey>& keys);
  static const ApiKey* FindKey(const Table& table, std::string_view secret);
  // The use after one more request. Throws as Charge.
  static Use Charged(const ApiKey& key, const Now& now, Use use);
  static void TakeToken(const ApiKey& key, const Now& now, Use* use);

  mutable std::mutex mutex_;
  std::shared_ptr<const Table> table_;
  std::unordered_map<std::string, Use> uses_;  // By label.
};

}  // namespace cairn

#endif  // CAIRN_HTTP_KEYS_KEY_RING_H_
