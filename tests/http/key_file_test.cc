#include "http/keys/key_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::TempDir;

const std::string kHex(64, 'a');

std::string FileWith(const std::string& keys) {
  return R"({"format":"cairn api keys","version":1,"keys":[)" + keys + "]}";
}

std::string KeyJson(const std::string& label, const std::string& hex,
                    const std::string& more = "") {
  return R"({"label":")" + label + R"(","sha256":")" + hex + R"(","may":["localize"])" + more + "}";
}

std::string FileRefusal(const std::string& text) {
  try {
    ParseKeys(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    return error.what();
  }
  return "accepted";
}

mode_t ModeOf(const std::string& path) {
  struct stat info {};
  EXPECT_EQ(stat(path.c_str(), &info), 0);
  return info.st_mode & 07777;
}

std::string TextOfFile(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

ApiKey NamedKey(const std::string& label) {
  return {.label = label, .hash = HashOfSecret(label), .may = KeyRight::kLocalize};
}

TEST(KeyFile, ReadsWhatItWrites) {
  ApiKey all = NamedKey("acme-app.2026");
  all.may = KeyRight::kLocalize | KeyRight::kLook | KeyRight::kCopy;
  all.rate_per_s = 2.5;
  all.burst = 20;
  all.quota_per_day = 100'000;
  const std::vector<ApiKey> keys = ParseKeys(KeysAsText({all, NamedKey("robot")}));
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].label, "acme-app.2026");
  EXPECT_EQ(keys[0].hash, all.hash);
  EXPECT_EQ(keys[0].may, all.may);
  EXPECT_EQ(keys[0].rate_per_s, 2.5);
  EXPECT_EQ(keys[0].burst, 20);
  EXPECT_EQ(keys[0].quota_per_day, 100'000);
  EXPECT_EQ(keys[1].may, KeyRights(KeyRight::kLocalize));
  EXPECT_FALSE(keys[1].rate_per_s || keys[1].burst || keys[1].quota_per_day);
  EXPECT_TRUE(ParseKeys(KeysAsText({})).empty());
}

TEST(KeyFile, HoldsAsManyKeysAsItMay) {
  std::vector<ApiKey> keys;
  for (size_t i = 0; i < kMaxKeys; ++i) {
    ApiKey& key = keys.emplace_back(NamedKey("k" + std::to_string(i)));
    key.may = KeyRight::kLocalize | KeyRight::kLook | KeyRight::kCopy;
    key.rate_per_s = 1.0;
    key.burst = 1;
    key.quota_per_day = 1;
  }
  EXPECT_EQ(ParseKeys(KeysAsText(keys)).size(), kMaxKeys);
  keys.push_back(NamedKey("one-more"));
  EXPECT_THROW(ParseKeys(KeysAsText(keys)), Error);
}

TEST(KeyFile, NamesWhatIsWrong) {
  const std::string good = KeyJson("a", kHex);
  EXPECT_EQ(FileRefusal(FileWith(good)), "accepted");
  const std::string other(64, 'b');
  const struct {
    std::string text;
    const char* message;
  } cases[] = {
      {"", "JSON"},
      {"[]", "object"},
      {R"({"format":"cairn query list","version":1,"keys":[]})", "/format"},
      {R"({"format":"cairn api keys","version":2,"keys":[]})", "/version: is not 1"},
      {R"({"format":"cairn api keys","version":1})", "keys"},
      {FileWith(KeyJson("", kHex)), "label ''"},
      {FileWith(KeyJson("two words", kHex)), "label 'two words'"},
      {FileWith(KeyJson("a\\nb", kHex)), "label 'a\\nb'"},
      {FileWith(KeyJson(std::string(65, 'l'), kHex)), "1 to 64"},
      {FileWith(KeyJson("a", kHex.substr(1))), "/keys/0/sha256: is not 64"},
      {FileWith(KeyJson("a", std::string(64, 'A'))), "lower case"},
      {FileWith(KeyJson("a", std::string(64, 'g'))), "/keys/0/sha256"},
      {FileWith(R"({"label":"a","sha256":")" + kHex + R"(","may":[]})"), "/keys/0/may"},
      {FileWith(R"({"label":"a","sha256":")" + kHex + R"(","may":["fly"]})"), "'fly'"},
      {FileWith(R"({"label":"a","may":["look"]})"), "sha256"},
      {FileWith(KeyJson("a", kHex, R"(,"rate":0)")), "rate = 0"},
      {FileWith(KeyJson("a", kHex, R"(,"rate":-1)")), "rate"},
      {FileWith(KeyJson("a", kHex, R"(,"burst":3)")), "burst needs a rate"},
      {FileWith(KeyJson("a", kHex, R"(,"quota":0)")), "quota"},
      {FileWith(KeyJson("a", kHex, R"(,"quota":1.5)")), "quota"},
      {FileWith(KeyJson("a", kHex, R"(,"secret":"x")")), "secret"},
      {FileWith(good + "," + KeyJson("a", other)), "/keys/1/label: 'a' is the label of two keys"},
      {FileWith(good + "," + KeyJson("b", kHex)), "/keys/1/sha256: belongs to two labels"},
  };
  for (const auto& bad : cases) {
    EXPECT_THAT(FileRefusal(bad.text), HasSubstr(bad.message)) << bad.text;
  }
}

TEST(KeyFile, IsForItsOwnerOnly) {
  const TempDir dir;
  const std::string path = dir.File("keys.json");
  ChangeKeyFile(path, [](std::vector<ApiKey>* keys) { keys->push_back(NamedKey("first")); });
  EXPECT_EQ(ModeOf(path), 0600u);
  EXPECT_EQ(ReadKeyFile(path).at(0).label, "first");
}

// The group of a service may read its keys; the whole machine may not, not even by mistake.
TEST(KeyFile, KeepsItsModeWithoutTheRightsOfOthers) {
  const TempDir dir;
  const std::string path = dir.File("keys.json");
  std::ofstream(path) << FileWith("");
  ASSERT_EQ(chmod(path.c_str(), 0664), 0);
  ::testing::internal::CaptureStderr();
  ChangeKeyFile(path, [](std::vector<ApiKey>* keys) { keys->push_back(NamedKey("first")); });
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("mode of the file of API keys is 0664"));
  EXPECT_THAT(log, HasSubstr("its mode was 0664 and is 0640 now"));
  EXPECT_EQ(ModeOf(path), 0640u);
  ::testing::internal::CaptureStderr();
  ReadKeyFile(path);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), Not(HasSubstr("mode")));
}

TEST(KeyFile, StaysAsItWasIfAChangeFails) {
  const TempDir dir;
  const std::string path = dir.File("keys.json");
  const auto fail = [](std::vector<ApiKey>*) { throw Error(ErrorCode::kNotFound, "no such key"); };
  EXPECT_THROW(ChangeKeyFile(path, fail), Error);
  EXPECT_NE(access(path.c_str(), F_OK), 0) << "no file appears";
  std::ofstream(path) << "{ not JSON";
  EXPECT_THROW(ChangeKeyFile(path, [](std::vector<ApiKey>*) {}), Error);
  EXPECT_EQ(TextOfFile(path), "{ not JSON");
}

// A pipe without a writer would stop the thread that waits for signals.
TEST(KeyFile, IsNoPipe) {
  const TempDir dir;
  const std::string path = dir.File("pipe");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  try {
    ReadKeyFile(path);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(), HasSubstr(path + ": is no regular file"));
  }
  EXPECT_THROW(ChangeKeyFile(path, [](std::vector<ApiKey>*) {}), Error);
}

TEST(KeyFile, ChangesBehindALink) {
  const TempDir dir;
  const std::string path = dir.File("keys.json"), link = dir.File("link.json");
  std::ofstream(path) << FileWith("");
  ASSERT_EQ(symlink(path.c_str(), link.c_str()), 0);
  ChangeKeyFile(link, [](std::vector<ApiKey>* keys) { keys->push_back(NamedKey("first")); });
  struct stat info {};
  ASSERT_EQ(lstat(link.c_str(), &info), 0);
  EXPECT_TRUE(S_ISLNK(info.st_mode));
  EXPECT_EQ(ReadKeyFile(path).size(), 1u);
}

TEST(KeyFile, LosesNoChangeOfManyAtOnce) {
  const TempDir dir;
  const std::string path = dir.File("keys.json");
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&path, i] {
      ChangeKeyFile(path, [i](std::vector<ApiKey>* keys) {
        keys->push_back(NamedKey("k" + std::to_string(i)));
      });
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(ReadKeyFile(path).size(), 8u);
}

TEST(Secret, HasRandomBitsAndAKnownHash) {
  const std::string secret = NewSecret();
  EXPECT_THAT(secret, ::testing::MatchesRegex("cairn_[-_A-Za-z0-9]{43}"));
  EXPECT_NE(secret, NewSecret());
  // FIPS 180-4, example of one block.
  EXPECT_EQ(HexOf(HashOfSecret("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(HashFromHex(HexOf(HashOfSecret(secret))), HashOfSecret(secret));
}

}  // namespace
}  // namespace cairn
