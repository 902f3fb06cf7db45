#include "http/keys/key_ring.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "core/wire/problem.h"
#include "http/keys/presented_key.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int64_t kDay = 86'400;

ApiKey KeyOf(const std::string& label, KeyRights may = KeyRight::kLocalize) {
  return {.label = label, .hash = HashOfSecret("secret of " + label), .may = may};
}

KeyRing::Now At(double seconds) {
  return {.steady = std::chrono::steady_clock::time_point(
              std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                  std::chrono::duration<double>(1000.0 + seconds))),
          .unix_s = 20'000 * kDay + static_cast<int64_t>(seconds)};
}

struct KeyRefusal {
  int status = 200;
  std::string text;  // Detail and hint.
  std::map<std::string, std::string> headers;
};

template <typename Function>
KeyRefusal KeyRefusalOf(const Function& function) {
  try {
    function();
  } catch (const HttpError& error) {
    return {InfoOf(error.problem()).status,
            error.what() + (" " + error.hint()),
            {error.headers().begin(), error.headers().end()}};
  }
  return {};
}

KeyRefusal Use(KeyRing* ring, const std::string& secret, double seconds,
               KeyRights needed = KeyRight::kLocalize) {
  return KeyRefusalOf([&] {
    const KeyRing::Holder holder = ring->Identify(secret);
    KeyRing::RequireRight(holder, needed);
    ring->Charge(holder, At(seconds));
  });
}

TEST(KeyRing, KnowsItsKeysOnly) {
  KeyRing ring({KeyOf("a"), KeyOf("b")});
  EXPECT_EQ(ring.Identify("secret of a").key.label, "a");
  EXPECT_EQ(ring.Identify("secret of b").key.label, "b");
  EXPECT_NE(ring.Identify("secret of a").client, ring.Identify("secret of b").client);
  for (const std::string& wrong :
       {std::string("secret of c"), std::string(), std::string("secret of a "),
        HexOf(HashOfSecret("secret of a")), std::string(100'000, 'x'), std::string("a")}) {
    KeyRefusal refusal = KeyRefusalOf([&] { ring.Identify(wrong); });
    EXPECT_EQ(refusal.status, 401);
    EXPECT_THAT(refusal.headers["WWW-Authenticate"], HasSubstr("invalid_token"));
  }
}

TEST(KeyRing, SaysHowToSendAKeyAndRepeatsNone) {
  KeyRing ring({KeyOf("a")});
  KeyRefusal missing = KeyRefusalOf([&] { ring.Identify(std::nullopt); });
  EXPECT_EQ(missing.status, 401);
  EXPECT_EQ(missing.headers["WWW-Authenticate"], "Bearer realm=\"cairn\"");
  EXPECT_THAT(missing.text, HasSubstr("Authorization: Bearer KEY"));
  EXPECT_THAT(KeyRefusalOf([&] { ring.Identify("typed-wrongly"); }).text,
              Not(HasSubstr("typed-wrongly")));
}

TEST(KeyRing, GivesTheRightsOfTheKey) {
  KeyRing ring({KeyOf("a", KeyRight::kLocalize | KeyRight::kLook)});
  EXPECT_EQ(Use(&ring, "secret of a", 0, KeyRight::kLook).status, 200);
  EXPECT_EQ(Use(&ring, "secret of a", 0, KeyRight::kCopy | KeyRight::kLook).status, 200);
  KeyRefusal refusal = Use(&ring, "secret of a", 0, KeyRight::kCopy);
  EXPECT_EQ(refusal.status, 403);
  EXPECT_THAT(refusal.text, HasSubstr("a key that may copy; the key 'a' may localize, look"));
  EXPECT_THAT(refusal.headers["WWW-Authenticate"], HasSubstr("scope=\"copy\""));
}

TEST(KeyRing, KeepsTheRateAndSaysWhenToReturn) {
  ApiKey key = KeyOf("a");
  key.rate_per_s = 0.5;
  key.burst = 2;
  KeyRing ring({key, KeyOf("b")});
  EXPECT_EQ(Use(&ring, "secret of a", 0).status, 200);
  EXPECT_EQ(Use(&ring, "secret of a", 0).status, 200);
  KeyRefusal refusal = Use(&ring, "secret of a", 0.5);
  EXPECT_EQ(refusal.status, 429);
  EXPECT_EQ(refusal.headers["Retry-After"], "2");
  EXPECT_EQ(Use(&ring, "secret of b", 0.5).status, 200) << "another client is not concerned";
  EXPECT_EQ(Use(&ring, "secret of a", 2.0).status, 200) << "one request every two seconds";
  EXPECT_EQ(Use(&ring, "secret of a", 2.1).status, 429);
  EXPECT_EQ(Use(&ring, "secret of a", 1e6).status, 200);
  EXPECT_EQ(Use(&ring, "secret of a", 1e6).status, 200);
  EXPECT_EQ(Use(&ring, "secret of a", 1e6).status, 429)
      << "a long pause earns no more than the burst";
}

TEST(KeyRing, CountsNothingWhereItOnlyChecks) {
  ApiKey key = KeyOf("a");
  key.rate_per_s = 0.5;
  key.burst = 1;
  KeyRing ring({key});
  const auto check = [&ring](double seconds) {
    return KeyRefusalOf([&] { ring.CheckUse(ring.Identify("secret of a"), At(seconds)); });
  };
  EXPECT_EQ(check(0).status, 200);
  EXPECT_EQ(check(0).status, 200);
  EXPECT_EQ(Use(&ring, "secret of a", 0).status, 200);
  KeyRefusal refusal = check(0.5);
  EXPECT_EQ(refusal.status, 429);
  EXPECT_EQ(refusal.headers["Retry-After"], "2");
  EXPECT_EQ(check(2.0).status, 200);
}

TEST(KeyRing, KeepsTheQuotaOfTheDay) {
  ApiKey key = KeyOf("a");
  key.quota_per_day = 2;
  KeyRing ring({key});
  const double evening = kDay - 3600;
  EXPECT_EQ(Use(&ring, "secret of a", evening).status, 200);
  EXPECT_EQ(Use(&ring, "secret of a", evening).status, 200);
  KeyRefusal refusal = Use(&ring, "secret of a", evening);
  EXPECT_EQ(refusal.status, 429);
  EXPECT_EQ(refusal.headers["Retry-After"], "3600");
  EXPECT_EQ(Use(&ring, "secret of a", kDay).status, 200);
}

TEST(KeyRing, DoesNotCountWhatItRefuses) {
  ApiKey key = KeyOf("a");
  key.rate_per_s = 1.0;
  key.quota_per_day = 2;
  KeyRing ring({key});
  EXPECT_EQ(Use(&ring, "secret of a", 0, KeyRight::kCopy).status, 403);
  EXPECT_EQ(Use(&ring, "secret of a", 0).status, 200);
  EXPECT_EQ(Use(&ring, "secret of a", 0).status, 429);
  EXPECT_EQ(Use(&ring, "secret of a", 1).status, 200);
}

TEST(KeyRing, KeepsTheUseOfLabelsThatStay) {
  ApiKey key = KeyOf("a");
  key.quota_per_day = 1;
  KeyRing ring({key, KeyOf("b")});
  EXPECT_EQ(Use(&ring, "secret of a", 0).status, 200);
  ring.Replace({key});
  EXPECT_EQ(Use(&ring, "secret of a", 0).status, 429);
  EXPECT_EQ(Use(&ring, "secret of b", 0).status, 401);
}

std::optional<std::string> Presented(
    const std::vector<std::pair<std::string, std::string>>& headers) {
  return PresentedKey(headers);
}

TEST(PresentedKey, ComesInTwoHeaders) {
  EXPECT_EQ(Presented({{"authorization", "Bearer abc"}}), "abc");
  EXPECT_EQ(Presented({{"authorization", "bearer   abc "}}), "abc");
  EXPECT_EQ(Presented({{"x-api-key", "abc"}}), "abc");
  EXPECT_EQ(Presented({{"x-api-key", "abc"}, {"authorization", "Bearer abc"}}), "abc");
  EXPECT_EQ(Presented({{"authorization", "Basic Zm9v"}, {"x-api-key", "abc"}}), "abc")
      << "a front has its own scheme";
  EXPECT_EQ(Presented({{"authorization", "Bearer"}}), "");
  EXPECT_EQ(Presented({{"authorization", "Bearerabc"}}), std::nullopt);
  EXPECT_EQ(Presented({{"accept", "abc"}}), std::nullopt);
  EXPECT_EQ(KeyRefusalOf([] {
              Presented({{"x-api-key", "abc"}, {"authorization", "Bearer b"}});
            }).status,
            401);
}

}  // namespace
}  // namespace cairn
