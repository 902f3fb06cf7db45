// Tests what tells people how to call the program: help, suggestions, version, man pages,
// completion.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/options/nearest_name.h"
#include "cli/run_cairn.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// What a shell command prints to both streams.
std::string OutputOf(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::string output;
  std::array<char, 4096> buffer;
  for (size_t size = 1; size > 0;) {
    size = std::fread(buffer.data(), 1, buffer.size(), pipe);
    output.append(buffer.data(), size);
  }
  pclose(pipe);
  return output;
}

std::set<std::string> WordsOf(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

// The verbs that the help of the program lists.
std::vector<std::string> Verbs() {
  std::istringstream help(RunCairn({"--help"}).out);
  std::vector<std::string> verbs;
  std::string line;
  while (std::getline(help, line) && line != "Subcommands:") {
  }
  while (std::getline(help, line) && line.starts_with("  ")) {
    const std::string verb = line.substr(2, line.find(' ', 2) - 2);
    if (!verb.empty()) {  // Not a line that goes on.
      verbs.push_back(verb);
    }
  }
  return verbs;
}

class Manual : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(RunCairn({"write-manual", dir_.path().string()}).exit_code, 0);
  }

  std::filesystem::path Pages() const { return dir_.path() / "man1"; }

  // What bash offers for the word `index` of a command line.
  std::set<std::string> Completion(const std::string& words, int index) const {
    const std::string script = "source " + (dir_.path() / "completions/cairn").string() +
                               "; COMP_WORDS=(" + words + "); COMP_CWORD=" + std::to_string(index) +
                               "; _cairn; printf \"%s\\n\" \"${COMPREPLY[@]}\"";
    return WordsOf(OutputOf("cd " + dir_.path().string() + " && bash --norc -c '" + script + "'"));
  }

  TempDir dir_;
};

TEST(Help, OfAVerbIsWhatTheVerbPrints) {
  ASSERT_GT(Verbs().size(), 20u);
  EXPECT_EQ(RunCairn({"help"}).out, RunCairn({"--help"}).out);
  EXPECT_EQ(RunCairn({"help", "localize"}).out, RunCairn({"localize", "--help"}).out);
  EXPECT_EQ(RunCairn({"help", "keys", "new"}).out, RunCairn({"keys", "new", "--help"}).out);
}

TEST(Help, OfAnUnknownVerbNamesTheNearest) {
  const Finished finished = RunCairn({"help", "keys", "nwe"});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err, HasSubstr("there is no verb 'keys nwe'; did you mean 'new'?"));
}

TEST(Help, NamesTheVerbThatWasMeant) {
  EXPECT_THAT(RunCairn({"chekc", "map"}).err, HasSubstr("'chekc'; did you mean 'check'?"));
  EXPECT_THAT(RunCairn({"localizze"}).err, HasSubstr("did you mean 'localize'?"));
  EXPECT_THAT(RunCairn({"keys", "lst"}).err, HasSubstr("did you mean 'list'?"));
  EXPECT_THAT(RunCairn({"xyzzy"}).err, Not(HasSubstr("did you mean")));
}

TEST(Help, NamesTheOptionThatWasMeant) {
  // Even if what the verb requires is missing, too.
  EXPECT_THAT(RunCairn({"localize", "map", "--imge", "photo.jpg"}).err,
              HasSubstr("there is no option '--imge'; did you mean '--image'?"));
  EXPECT_THAT(RunCairn({"info", "map", "--progres=json"}).err, HasSubstr("'--progress'?"));
  EXPECT_THAT(RunCairn({"--verson"}).err, HasSubstr("'--version'?"));
  EXPECT_EQ(RunCairn({"info", "map", "--jsn"}).exit_code, 2);
}

TEST(Help, WordsOfAnOptionStandInTheErrorAndInTheHelp) {
  const std::vector<std::vector<std::string>> lines = {
      {"eval", "m", "--server", "http://x", "--send", "imge"},
      {"eval", "m", "--align-to", "mpa"},
      {"sql", "m", "--format", "jsn"},
      {"localize", "m", "--index", "random_grid"},
      {"localize", "m", "--prior", "1,2,3", "--height", "elipsoid"},
      {"ingest", "m", "--codebook", "shiped"},
      {"info", "m", "--progress", "plian"},
      {"info", "m", "--log-level", "warn"}};
  for (const std::vector<std::string>& line : lines) {
    const Finished finished = RunCairn(line);
    const std::string& option = line[line.size() - 2];
    EXPECT_EQ(finished.exit_code, 2) << option;
    EXPECT_THAT(finished.err,
                HasSubstr("cairn: " + option + ": '" + line.back() + "' is not one of "));
    EXPECT_THAT(finished.err, HasSubstr("; did you mean '")) << option;
  }
  EXPECT_THAT(RunCairn({"eval", "--help"}).out, HasSubstr("--send image|features"));
  EXPECT_THAT(RunCairn({"ingest", "--help"}).out, HasSubstr("--codebook auto|shipped|trained"));
}

TEST(Help, VersionTellsWhatTheProgramWasBuiltFrom) {
  for (const Finished& finished : {RunCairn({"--version"}), RunCairnLab({"--version"})}) {
    EXPECT_THAT(finished.out, StartsWith("cairn"));
    EXPECT_THAT(finished.out, HasSubstr("\ncommit     "));
    EXPECT_THAT(finished.out, HasSubstr("\ncompiler   "));
    EXPECT_THAT(finished.out, HasSubstr("Eigen 3."));
    EXPECT_THAT(finished.out, Not(HasSubstr(" ,"))) << "a library without a version";
  }
}

TEST(NearestName, ToleratesTyposAndHalfWords) {
  EXPECT_EQ(EditDistance("chekc", "check"), 1u);
  EXPECT_EQ(EditDistance("", "abc"), 3u);
  EXPECT_EQ(DidYouMean("loc", {"log", "localize"}), "; did you mean 'log'?");
  EXPECT_EQ(DidYouMean("local", {"log", "localize"}), "; did you mean 'localize'?");
  EXPECT_EQ(DidYouMean("--out-put", {"--json", "--output"}), "; did you mean '--output'?");
  EXPECT_EQ(DidYouMean("quux", {"log", "localize"}), "");
  EXPECT_EQ(DidYouMean(std::string(1 << 20, 'x'), {"log"}), "");
  EXPECT_EQ(DidYouMean("x", {}), "");
}

TEST_F(Manual, HasAPageForEachVerb) {
  for (const std::string& verb : Verbs()) {
    EXPECT_TRUE(std::filesystem::exists(Pages() / ("cairn-" + verb + ".1"))) << verb;
  }
  EXPECT_TRUE(std::filesystem::exists(Pages() / "cairn.1"));
  EXPECT_TRUE(std::filesystem::exists(Pages() / "cairn-keys-new.1"));
  EXPECT_FALSE(std::filesystem::exists(Pages() / "cairn-write-manual.1"));
}

TEST_F(Manual, PagesAreCleanForGroffAndMandoc) {
  if (OutputOf("command -v groff").empty()) {
    GTEST_SKIP() << "groff is not installed";
  }
  const std::string pages = Pages().string() + "/*.1";
  EXPECT_EQ(OutputOf("groff -man -Tutf8 -ww -z " + pages), "");
  if (!OutputOf("command -v mandoc").empty()) {
    // A page of no known date, as of an archive without git, has no date; nothing else is amiss.
    EXPECT_EQ(OutputOf("mandoc -Tlint " + pages + " | grep -v 'missing date'"), "");
  }
}

TEST_F(Manual, PageTellsOptionsExamplesAndExitCodes) {
  if (OutputOf("command -v groff").empty()) {
    GTEST_SKIP() << "groff is not installed";
  }
  const std::string page = OutputOf("groff -man -Tascii -P-c " +
                                    (Pages() / "cairn-eval.1").string() + " | sed 's/.\\x08//g'");
  EXPECT_THAT(page, HasSubstr("cairn-eval - Measure accuracy"));
  EXPECT_THAT(page, HasSubstr("--send image|features"));
  EXPECT_THAT(page, HasSubstr("cairn eval city.gpkg --model sparse/0"));
  EXPECT_THAT(page, HasSubstr("damaged"));
}

TEST_F(Manual, BashCompletesVerbsOptionsAndWords) {
  EXPECT_EQ(Completion("cairn loc", 1), (std::set<std::string>{"localize"}));
  EXPECT_EQ(Completion("cairn help rol", 2), (std::set<std::string>{"rollback"}));
  EXPECT_EQ(Completion("cairn keys \"\"", 2), (std::set<std::string>{"list", "new", "remove"}));
  EXPECT_EQ(Completion("cairn keys new --ra", 3), (std::set<std::string>{"--rate"}));
  EXPECT_EQ(Completion("cairn localize --index r", 3), (std::set<std::string>{"random_grids"}));
  EXPECT_EQ(Completion("cairn localize --index = i", 4), (std::set<std::string>{"inverted_lists"}));
  EXPECT_EQ(Completion("cairn info m --progress \"\"", 4),
            (std::set<std::string>{"auto", "bar", "json", "plain"}));
  EXPECT_EQ(Completion("cairn --progress json che", 3), (std::set<std::string>{"check"}));
  EXPECT_EQ(Completion("cairn info --pro", 2), (std::set<std::string>{"--progress"}));
  EXPECT_TRUE(Completion("cairn write", 1).empty()) << "a hidden verb";
}

TEST_F(Manual, BashCompletesFilesWhereFilesAreMeant) {
  std::ofstream(dir_.File("city map.gpkg")) << "x";
  EXPECT_EQ(Completion("cairn info cit", 2), (std::set<std::string>{"city", "map.gpkg"}));
  EXPECT_EQ(Completion("cairn localize m --image ci", 4),
            (std::set<std::string>{"city", "map.gpkg"}));
  EXPECT_TRUE(Completion("cairn serve m --port ci", 4).empty());
}

TEST_F(Manual, BashKnowsEachVerbOfTheHelp) {
  const std::vector<std::string> verbs = Verbs();
  EXPECT_EQ(Completion("cairn \"\"", 1), std::set<std::string>(verbs.begin(), verbs.end()));
}

}  // namespace
}  // namespace cairn::testing
