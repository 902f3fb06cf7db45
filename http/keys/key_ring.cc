#include "http/keys/key_ring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/wire/problem.h"

namespace cairn {
namespace {

constexpr int64_t kSecondsPerDay = 86'400;
constexpr char kHowToSend[] = "send the header 'Authorization: Bearer KEY' or 'X-API-Key: KEY'";

uint64_t FirstBytes(const KeyHash& hash) {
  uint64_t number = 0;
  std::memcpy(&number, hash.data(), sizeof(number));
  return number;
}

[[noreturn]] void RefuseUse(const std::string& detail, double seconds) {
  const auto whole = static_cast<int64_t>(std::max(1.0, std::ceil(seconds)));
  throw HttpError(ProblemCode::kTooManyRequests, detail)
      .Header("Retry-After", std::to_string(whole))
      .Hint(fmt::format("ask again in {} s", whole));
}

}  // namespace

std::shared_ptr<const KeyRing::Table> KeyRing::MakeTable(const std::vector<ApiKey>& keys) {
  while (true) {
    auto table =
        std::make_shared<Table>(Table{.salt = RandomBits(), .keys = keys, .by_salted_hash = {}});
    for (size_t i = 0; i < keys.size(); ++i) {
      table->by_salted_hash.emplace(FirstBytes(SaltedHash(table->salt, keys[i].hash)), i);
    }
    if (table->by_salted_hash.size() == keys.size()) {
      return table;  // Two keys that meet would need another salt.
    }
  }
}

void KeyRing::Replace(const std::vector<ApiKey>& keys) {
  std::shared_ptr<const Table> table = MakeTable(keys);
  const std::lock_guard lock(mutex_);
  std::unordered_map<std::string, Use> uses;
  for (const ApiKey& key : keys) {
    if (const auto found = uses_.find(key.label); found != uses_.end()) {
      uses.insert(*found);
    }
  }
  uses_ = std::move(uses);
  table_ = std::move(table);
}

const ApiKey* KeyRing::FindKey(const Table& table, std::string_view secret) {
  static constexpr KeyHash kNoHash{};
  if (secret.empty() || secret.size() > kMaxSecretBytes) {
    return nullptr;
  }
  const KeyHash hash = HashOfSecret(secret);
  const auto found = table.by_salted_hash.find(FirstBytes(SaltedHash(table.salt, hash)));
  const ApiKey* const key =
      found == table.by_salted_hash.end() ? nullptr : &table.keys[found->second];
  const bool is_equal = AreEqual(hash, key == nullptr ? kNoHash : key->hash);
  return is_equal ? key : nullptr;
}

KeyRing::Holder KeyRing::Identify(const std::optional<std::string>& presented) const {
  if (!presented) {
    throw HttpError(ProblemCode::kUnauthorized, "this route needs an API key")
        .Header("WWW-Authenticate", "Bearer realm=\"cairn\"")
        .Hint(kHowToSend);
  }
  std::shared_ptr<const Table> table;
  {
    const std::lock_guard lock(mutex_);
    table = table_;
  }
  const ApiKey* const key = FindKey(*table, *presented);
  if (key == nullptr) {
    throw HttpError(ProblemCode::kUnauthorized, "the server does not know this API key")
        .Header("WWW-Authenticate", "Bearer realm=\"cairn\", error=\"invalid_token\"")
        .Hint("the key may be misspelt or removed");
  }
  return {.key = *key, .client = FirstBytes(HashOfSecret(key->label))};
}

void KeyRing::RequireRight(const Holder& holder, KeyRights needed) {
  if (holder.key.may.Meets(needed)) {
    return;
  }
  throw HttpError(
      ProblemCode::kForbidden,
      fmt::format("this route needs a key that may {}; the key '{}' may {}",
                  NamesOf(needed, " or "), holder.key.label, NamesOf(holder.key.may, ", ")))
      .Header("WWW-Authenticate",
              fmt::format("Bearer realm=\"cairn\", error=\"insufficient_scope\", scope=\"{}\"",
                          NamesOf(needed, " ")));
}

void KeyRing::Charge(const Holder& holder, const Now& now) {
  const std::lock_guard lock(mutex_);
  Use& use = uses_[holder.key.label];
  use = Charged(holder.key, now, use);
}

void KeyRing::CheckUse(const Holder& holder, const Now& now) const {
  const std::lock_guard lock(mutex_);
  const auto found = uses_.find(holder.key.label);
  Charged(holder.key, now, found == uses_.end() ? Use() : found->second);
}

KeyRing::Use KeyRing::Charged(const ApiKey& key, const Now& now, Use use) {
  if (const int64_t day = now.unix_s / kSecondsPerDay; day != use.day) {
    use.day = day;
    use.num_requests = 0;
  }
  if (key.quota_per_day && use.num_requests >= *key.quota_per_day) {
    RefuseUse(
        fmt::format("the key '{}' may send {} requests a day (UTC)", key.label, *key.quota_per_day),
        static_cast<double>(kSecondsPerDay - now.unix_s % kSecondsPerDay));
  }
  if (key.rate_per_s) {
    TakeToken(key, now, &use);
  }
  ++use.num_requests;
  return use;
}

void KeyRing::TakeToken(const ApiKey& key, const Now& now, Use* use) {
  const double pause_s =
      use->refilled ? std::chrono::duration<double>(now.steady - *use->refilled).count() : 0.0;
  const double before = use->refilled ? use->tokens : key.Burst();
  use->tokens = std::min(key.Burst(), before + std::max(0.0, pause_s) * *key.rate_per_s);
  use->refilled = std::max(now.steady, use->refilled.value_or(now.steady));
  if (use->tokens < 1.0) {
    RefuseUse(fmt::format("the key '{}' may send {} requests a second, and {} at once", key.label,
                          *key.rate_per_s, key.Burst()),
              (1.0 - use->tokens) / *key.rate_per_s);
  }
  use->tokens -= 1.0;
}

}  // namespace cairn
