// Options by name: what a file may set, and what it is told when it is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <string>
#include <variant>

#include "cli/options/read_options.h"
#include "cli/options/write_options.h"
#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// What the reader says to a text, "kind: message"; empty if it takes the text.
std::string Refusal(const std::string& json) {
  CairnOptions options;
  const std::string before = OptionsAsJson(options);
  try {
    ReadOptions(json, &options);
  } catch (const Error& error) {
    EXPECT_EQ(OptionsAsJson(options), before) << "an error must leave the options alone";
    return std::string(ErrorCodeName(error.code())) + ": " + error.what();
  }
  return "";
}

CairnOptions Read(const std::string& json) {
  CairnOptions options;
  ReadOptions(json, &options);
  return options;
}

TEST(Options, DefaultsAreWrittenAndReadBack) {
  const std::string json = OptionsAsJson(CairnOptions());
  EXPECT_EQ(OptionsAsJson(Read(json)), json);
}

// A value of the type of the option that no default has.
void ChangeValue(OptionValue* value) {
  if (auto* choice = std::get_if<NamedChoice>(value)) {
    choice->Set(choice->Get() == choice->names()[0] ? choice->names()[1] : choice->names()[0]);
  } else if (double** number = std::get_if<double*>(value)) {
    **number = std::isinf(**number) ? 1.5 : 0.75 * **number + 1e-3;
  } else if (int** small = std::get_if<int*>(value)) {
    **small += 1;
  } else if (int64_t** large = std::get_if<int64_t*>(value)) {
    **large += 1;
  } else {
    **std::get_if<uint64_t*>(value) += 1;
  }
}

TEST(Options, EachIsWrittenWhereItIsRead) {
  CairnOptions defaults;
  const size_t num_options = Describe(&defaults).options().size();
  std::set<std::string> texts = {OptionsAsJson(defaults)};
  for (size_t i = 0; i < num_options; ++i) {
    CairnOptions changed;
    OptionList list = Describe(&changed);
    if (list.options()[i].name == "ingest.codebook.num_subspaces") {
      changed.ingest.codebook.num_subspaces = 16;  // Has to divide projected_dim.
    } else if (list.options()[i].name == "ingest.codebook.projected_dim") {
      changed.ingest.codebook.projected_dim = 24;
    } else if (list.options()[i].name == "matching.distance_filter") {
      changed.localizer.matching.distance_filter = DistanceFilter::kNone;
    } else if (list.options()[i].name == "server.max_timeout_ms") {
      changed.server.max_timeout_ms = 5000;  // The default is the largest value.
    } else {
      ChangeValue(&list.options()[i].value);
    }
    const std::string json = OptionsAsJson(changed);
    EXPECT_TRUE(texts.insert(json).second) << list.options()[i].name;
    EXPECT_EQ(OptionsAsJson(Read(json)), json) << list.options()[i].name;
  }
}

TEST(Options, AFileSetsWhatItNamesAndNothingElse) {
  const CairnOptions options = Read(
      R"({"seed": 7, "voting": {"max_candidates": 12, "filter": "voting_3d"},
          "matching": {"index": {"lists": {"num_probes": 3}},
                       "max_orientation_difference_rad": 1.5},
          "ingest": {"selection": {"kind": "coverage", "max_landmarks": 200000}}})");
  EXPECT_EQ(options.localizer.seed, 7u);
  EXPECT_EQ(options.localizer.voting.max_candidates, 12);
  EXPECT_EQ(options.localizer.voting.filter, OutlierFilter::kVoting3d);
  EXPECT_EQ(options.localizer.matching.index.lists.num_probes, 3);
  EXPECT_EQ(options.localizer.matching.max_orientation_difference_rad, 1.5);
  EXPECT_EQ(options.ingest.selection.kind, LandmarkSelectionKind::kCoverage);
  EXPECT_EQ(options.ingest.selection.max_landmarks, 200'000);
  EXPECT_EQ(options.localizer.voting.cell_xy_m, VotingOptions().cell_xy_m);
}

TEST(Options, TakesInfinityByName) {
  const CairnOptions options =
      Read(R"({"answer": {"ambiguous_distance_m": "infinity", "min_score": 5}})");
  EXPECT_EQ(options.localizer.answer.ambiguous_distance_m, std::numeric_limits<double>::infinity());
  EXPECT_EQ(options.localizer.answer.min_score, 5.0);
}

TEST(Options, UnknownMembersAreNamedWithTheNearestOption) {
  EXPECT_EQ(Refusal(R"({"voting": {"max_candidate": 8}})"),
            "invalid_argument: voting.max_candidate is not an option; the nearest is "
            "voting.max_candidates");
  EXPECT_EQ(
      Refusal(R"({"max_candidates": 8})"),
      "invalid_argument: max_candidates is not an option; the nearest is voting.max_candidates");
  EXPECT_EQ(Refusal(R"({"votign": {}})"),
            "invalid_argument: votign is not an option; the nearest is voting");
  EXPECT_THAT(Refusal(R"({"": 1})"), HasSubstr("is not an option"));
}

TEST(Options, NamesHaveNoDots) {
  EXPECT_THAT(Refusal(R"({"voting.max_candidates": 8})"),
              AllOf(HasSubstr("invalid_argument: voting.max_candidates"), HasSubstr("no dot")));
}

TEST(Options, WrongTypesAreNamed) {
  EXPECT_EQ(Refusal(R"({"voting": {"max_candidates": "8"}})"),
            "invalid_argument: voting.max_candidates must be a whole number, not a string");
  EXPECT_EQ(Refusal(R"({"voting": {"max_candidates": 8.5}})"),
            "invalid_argument: voting.max_candidates = 8.5 must be a whole number");
  EXPECT_EQ(Refusal(R"({"voting": {"cell_xy_m": null}})"),
            "invalid_argument: voting.cell_xy_m must be a number or \"infinity\", not null");
  EXPECT_EQ(Refusal(R"({"voting": {"cell_xy_m": "wide"}})"),
            "invalid_argument: voting.cell_xy_m must be a number or \"infinity\", not a string");
  EXPECT_EQ(Refusal(R"({"pose": {"solver": 2}})"),
            "invalid_argument: pose.solver must be a string, not a number");
  EXPECT_EQ(Refusal(R"({"pose": {"solver": "newton"}})"),
            "invalid_argument: pose.solver = \"newton\" must be one of \"auto\", "
            "\"gravity_two_point\", \"p3p\"");
  EXPECT_EQ(Refusal(R"({"voting": 8})"),
            "invalid_argument: voting must be an object, not a number");
  EXPECT_EQ(Refusal("[]"), "invalid_argument: the top level must be an object, not an array");
}

TEST(Options, ValuesOutOfRangeAreNamed) {
  EXPECT_THAT(Refusal(R"({"voting": {"cell_xy_m": 0}})"),
              HasSubstr("invalid_argument: voting.cell_xy_m = 0 must lie in [0.1, 100]"));
  EXPECT_THAT(Refusal(R"({"voting": {"max_candidates": 1e12}})"),
              HasSubstr("invalid_argument: voting.max_candidates = "));
  EXPECT_THAT(Refusal(R"({"seed": -1})"), HasSubstr("invalid_argument: seed = -1 must lie in [0"));
  EXPECT_THAT(Refusal(R"({"seed": 9007199254740994})"), HasSubstr("invalid_argument: seed = "));
  EXPECT_THAT(Refusal(R"({"ingest": {"selection": {"max_landmarks": -1}}})"),
              HasSubstr("ingest.selection.max_landmarks"));
  EXPECT_THAT(Refusal(R"({"ingest": {"codebook": {"num_subspaces": 7}}})"),
              HasSubstr("ingest.codebook.num_subspaces"));
  EXPECT_THAT(Refusal(R"({"ingest": {"appearance": {"ratio": 2}}})"),
              HasSubstr("ingest.appearance.ratio"));
  EXPECT_THAT(Refusal(R"({"server": {"max_features": 0}})"), HasSubstr("server.max_features"));
  EXPECT_THAT(Refusal(R"({"sift": {"max_pixels": 0}})"), HasSubstr("sift.max_pixels"));
  EXPECT_THAT(Refusal(R"({"georegister": {"upright_sigma_rad": -1}})"),
              HasSubstr("georegister.upright_sigma_rad"));
}

TEST(Options, WhatIsNoJsonIsRefused) {
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("voting: 8"), std::string("{} {}"),
        std::string("{\"seed\": NaN}"), std::string("{\"seed\": 1e400}"), std::string("\xff"),
        std::string(R"({"seed": 1, "seed": 1})"), R"({"voting": )" + std::string(100, '[')}) {
    EXPECT_THAT(Refusal(text), ::testing::StartsWith("bad_input: ")) << text;
  }
  EXPECT_THAT(Refusal(R"({"pose": {"min_inliers": 6, "min_inliers": 7}})"),
              HasSubstr("two members 'min_inliers'"));
}

TEST(Options, AFileIsNamedAndOfBoundedSize) {
  const TempDir dir;
  const std::string path = dir.File("options.json");
  const auto refusal = [&](const std::string& text) -> std::string {
    std::ofstream(path, std::ios::binary) << text;
    CairnOptions options;
    try {
      ReadOptionsFile(path, &options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal("{\"seed\": 1" + std::string(65'000, ' ') + "}"), "");
  EXPECT_THAT(refusal("{\"seed\": 1" + std::string(65'536, ' ') + "}"),
              AllOf(HasSubstr(path), HasSubstr("65536 bytes")));
  EXPECT_EQ(refusal("{\"sed\": 1}"), path + ": sed is not an option; the nearest is seed");
}

}  // namespace
}  // namespace cairn::testing
