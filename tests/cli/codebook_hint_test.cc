#include "cli/codebook_hint.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

VersionRecord Version(VersionKind kind, const std::string& session = "") {
  VersionRecord version;
  version.kind = VersionKindName(kind);
  version.session = session;
  return version;
}

SessionRecord Session(const std::string& name, int64_t num_landmarks) {
  SessionRecord session;
  session.name = name;
  session.num_landmarks = num_landmarks;
  return session;
}

TEST(CodebookHint, TheFirstIngestTrained) {
  EXPECT_EQ(
      SessionThatTrained({Version(VersionKind::kIngest, "tuesday"),
                          Version(VersionKind::kIngest, "monday"), Version(VersionKind::kCreate)},
                         false),
      "monday");
}

TEST(CodebookHint, KnowsNothingOfShippedChosenAndPrunedOrigins) {
  const VersionRecord monday = Version(VersionKind::kIngest, "monday");
  const VersionRecord create = Version(VersionKind::kCreate);
  EXPECT_FALSE(SessionThatTrained({monday, create}, true));
  EXPECT_FALSE(SessionThatTrained({create}, false));
  EXPECT_FALSE(SessionThatTrained({monday}, false)) << "versions before it were pruned";
  for (const VersionKind kind :
       {VersionKind::kRecode, VersionKind::kMerge, VersionKind::kExtract, VersionKind::kRollback}) {
    EXPECT_FALSE(SessionThatTrained({Version(kind), monday, create}, false))
        << VersionKindName(kind);
  }
}

TEST(CodebookHint, NamesTheLargestSessionIfItIsMuchLargerThanTheTrainer) {
  EXPECT_EQ(SessionToTrainOn({Session("monday", 1000), Session("tuesday", 1999)}, "monday", false),
            nullptr);
  const std::vector<SessionRecord> grown = {Session("monday", 1000), Session("tuesday", 1500),
                                            Session("wednesday", 2000)};
  ASSERT_NE(SessionToTrainOn(grown, "monday", false), nullptr);
  EXPECT_EQ(SessionToTrainOn(grown, "monday", false)->name, "wednesday");
  EXPECT_EQ(SessionToTrainOn(grown, "wednesday", false), nullptr);
  EXPECT_EQ(SessionToTrainOn(grown, std::nullopt, false), nullptr) << "unknown origin";
  EXPECT_EQ(SessionToTrainOn({}, std::nullopt, true), nullptr);
}

TEST(CodebookHint, AShippedCodebookIsOutgrownOnceASessionCanTrain) {
  EXPECT_EQ(SessionToTrainOn({Session("few", 100)}, std::nullopt, true), nullptr);
  EXPECT_NE(SessionToTrainOn({Session("enough", 200)}, std::nullopt, true), nullptr);
}

TEST(CodebookHint, PrintsNoControlCharacters) {
  const std::string hint = RecodeHint(Session("a\033[2J", 200), "b\033[2J.gpkg");
  EXPECT_EQ(hint.find('\033'), std::string::npos);
  EXPECT_NE(hint.find("cairn recode"), std::string::npos);
}

}  // namespace
}  // namespace cairn
