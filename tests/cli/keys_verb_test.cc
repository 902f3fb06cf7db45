// Tests `cairn keys`, and the verbs that ask for keys or send them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "cli/run_cairn.h"
#include "core/images/gray_image.h"
#include "eval/pictures/encode_png.h"
#include "storage/map/map_store.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

class Keys : public ::testing::Test {
 protected:
  Keys() { unsetenv("CAIRN_API_KEY"); }
  ~Keys() override { unsetenv("CAIRN_API_KEY"); }

  Finished New(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"keys", "new", file_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCairn(arguments);
  }
  std::string NewSecretFor(const std::string& label) const {
    const Finished made = New({"--label", label});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    return made.out.substr(0, made.out.find('\n'));
  }
  static std::string TextOf(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  TempDir dir_;
  const std::string file_ = dir_.File("keys.json");
};

TEST_F(Keys, AreShownOnceAndStoredHashed) {
  const Finished made =
      New({"--label", "acme", "--rate", "5", "--quota", "1000", "--may", "localize,look"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, MatchesRegex("cairn_[-_A-Za-z0-9]{43}\n"));
  EXPECT_THAT(made.err, HasSubstr("the only time"));
  const std::string secret = made.out.substr(0, made.out.size() - 1);
  EXPECT_THAT(TextOf(file_), Not(HasSubstr(secret)));
  struct stat info {};
  ASSERT_EQ(stat(file_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0600u);
  const Finished listed = RunCairn({"keys", "list", file_});
  EXPECT_THAT(listed.out, HasSubstr("acme"));
  EXPECT_THAT(listed.out, HasSubstr("localize,look"));
  EXPECT_THAT(listed.out, HasSubstr("1000"));
  EXPECT_THAT(listed.out, Not(HasSubstr(secret)));
}

TEST_F(Keys, HaveOneLabelEach) {
  NewSecretFor("acme");
  const Finished again = New({"--label", "acme"});
  EXPECT_EQ(again.exit_code, 4);
  EXPECT_THAT(again.err, HasSubstr("has a key 'acme' already"));
  EXPECT_EQ(again.out, "");
  EXPECT_EQ(RunCairn({"keys", "remove", file_, "--label", "acme"}).exit_code, 0);
  EXPECT_EQ(RunCairn({"keys", "remove", file_, "--label", "acme"}).exit_code, 4);
  NewSecretFor("acme");
}

TEST_F(Keys, AreRefusedInWords) {
  const struct {
    std::vector<std::string> arguments;
    const char* message;
  } cases[] = {
      {{}, "--label"},
      {{"--label", "two words"}, "label 'two words'"},
      {{"--label", ""}, "label"},
      {{"--label", "a", "--may", "fly"}, "'fly' is neither localize, look nor copy"},
      {{"--label", "a", "--may", "look,"}, "'' is neither"},
      {{"--label", "a", "--rate", "0"}, "--rate"},
      {{"--label", "a", "--rate", "nan"}, "--rate"},
      {{"--label", "a", "--burst", "3"}, "--rate"},
      {{"--label", "a", "--rate", "1", "--burst", "0"}, "burst"},
      {{"--label", "a", "--quota", "-1"}, "quota"},
  };
  for (const auto& wrong : cases) {
    const Finished refused = New(wrong.arguments);
    EXPECT_EQ(refused.exit_code, 2) << refused.err;
    EXPECT_THAT(refused.err, HasSubstr(wrong.message));
    EXPECT_EQ(refused.out, "");
  }
  EXPECT_NE(access(file_.c_str(), F_OK), 0) << "no file appears";
  EXPECT_EQ(RunCairn({"keys", "list", file_}).exit_code, 4) << "there is no file";
  EXPECT_EQ(RunCairn({"keys", "remove", file_, "--label", "a"}).exit_code, 4);
  EXPECT_EQ(RunCairn({"keys", "new", dir_.path().string(), "--label", "a"}).exit_code, 6);
  std::ofstream(file_) << "label a";
  EXPECT_THAT(New({"--label", "a"}).err, HasSubstr(file_));
}

TEST_F(Keys, StayOffTheCommandLine) {
  const std::vector<std::vector<std::string>> verbs = {
      {"localize", "--image", "x.jpg", "--server", "http://h:1"},
      {"eval", "map.gpkg", "--server", "http://h:1"},
      {"serve", "map.gpkg"}};
  for (const std::vector<std::string>& arguments : verbs) {
    for (const bool joined : {false, true}) {
      std::vector<std::string> with_key = arguments;
      with_key.emplace_back(joined ? "--api-key=cairn_abc" : "--api-key");
      if (!joined) {
        with_key.emplace_back("cairn_abc");
      }
      const Finished refused = RunCairn(with_key);
      EXPECT_EQ(refused.exit_code, 2);
      EXPECT_THAT(refused.err, HasSubstr("everybody on this machine can read a key"));
      EXPECT_THAT(refused.err, Not(HasSubstr("cairn_abc")));
    }
  }
}

// A server of an empty map, and the questions of clients.
class ServedKeys : public Keys {
 protected:
  ServedKeys() {
    MapStore::Create(map_);
    const std::vector<uint8_t> png = EncodePng(BlankImage(64, 48));
    std::ofstream(photo_, std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  }
  Finished Ask(const std::string& url, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"localize", "--image",  photo_, "--prior",
                                          "47,8,400", "--server", url};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCairn(arguments);
  }

  static constexpr int kNotLocalized = 3;  // The server has answered.

  const std::string map_ = dir_.File("map.gpkg"), photo_ = dir_.File("photo.png");
};

TEST_F(ServedKeys, ComeFromAFileOrTheEnvironment) {
  const std::string secret = NewSecretFor("acme");
  BackgroundCairn server({"serve", map_, "--port", "0", "--api-keys", file_, "--log-level", "off"});
  const std::string url = server.ReadLine();
  const Finished without = Ask(url);
  EXPECT_EQ(without.exit_code, 4);
  EXPECT_THAT(without.err, HasSubstr("--api-key-file or CAIRN_API_KEY"));
  const std::string key_file = dir_.File("acme.key");
  std::ofstream(key_file) << secret << "\n";
  EXPECT_EQ(Ask(url, {"--api-key-file", key_file}).exit_code, kNotLocalized);
  setenv("CAIRN_API_KEY", secret.c_str(), 1);
  EXPECT_EQ(Ask(url).exit_code, kNotLocalized);
  setenv("CAIRN_API_KEY", "cairn_wrong", 1);
  const Finished wrong = Ask(url);
  EXPECT_EQ(wrong.exit_code, 4);
  EXPECT_THAT(wrong.err, HasSubstr("does not know this API key"));
  EXPECT_THAT(wrong.err, Not(HasSubstr("cairn_wrong")));
  EXPECT_EQ(Ask(url, {"--api-key-file", key_file}).exit_code, kNotLocalized)
      << "a file wins over the environment";
}

TEST_F(ServedKeys, AreNotSentWhereOthersCanReadThem) {
  setenv("CAIRN_API_KEY", "cairn_abc", 1);
  const Finished refused = Ask("http://192.0.2.1:8080");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--insecure-key"));
  EXPECT_THAT(refused.err, Not(HasSubstr("cairn_abc")));
}

TEST_F(ServedKeys, AreOneWord) {
  const std::string key_file = dir_.File("acme.key");
  for (const char* text : {"", "\n\n", "two words", "cairn_a\ncairn_b\n"}) {
    std::ofstream(key_file, std::ios::trunc) << text;
    const Finished refused = Ask("http://127.0.0.1:1", {"--api-key-file", key_file});
    EXPECT_EQ(refused.exit_code, 4);
    EXPECT_THAT(refused.err, HasSubstr(key_file + ": expected one word"));
    EXPECT_THAT(refused.err, Not(HasSubstr("cairn_a")));
  }
}

TEST_F(ServedKeys, AreNeededByAServerThatIsToldSo) {
  std::ofstream(file_) << R"({"format":"cairn api keys","version":1,"keys":[{}]})";
  const Finished refused = RunCairn({"serve", map_, "--port", "0", "--api-keys", file_});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err, HasSubstr(file_ + ": /keys/0"));
}

}  // namespace
}  // namespace cairn::testing
