// Tests the page of `cairn eval --report`.
#include "eval/report/report_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "engine/localizer.h"
#include "ingest/ingest_session.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A street that was mapped, and queries of it.
class ReportPage : public ::testing::Test {
 protected:
  ReportPage() {
    StreetWorldOptions world_options;
    world_options.length_m = 36.0;
    world_options.num_landmarks = 450;
    const StreetWorld world(world_options);
    MapStore::Create(map_path_);
    MapStore store = MapStore::Open(map_path_, OpenMode::kReadWrite);
    IngestOptions options;
    options.session_name = "monday";
    IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, &store, {});
    queries_ = QueriesFromReconstruction(world.Reconstruct(), world.EcefFromWorld(), "");
    queries_.resize(12);
    AddNoisyPriors({}, &queries_);
  }

  std::string Page() {
    const Localizer localizer = Localizer::Open(map_path_);
    report_ = Evaluate(queries_,
                       [&](const EvalQuery& query) { return localizer.Localize(query.query); }, {});
    return MakeReportPage("map <one>", localizer.map().Snapshot(), queries_, report_);
  }

  TempDir dir_;
  std::string map_path_ = dir_.File("map.gpkg");
  std::vector<EvalQuery> queries_;
  EvalReport report_;
};

std::set<std::string> AllOf(const std::string& page, const char* pattern) {
  const std::regex regex(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator match(page.begin(), page.end(), regex), end; match != end; ++match) {
    found.insert((*match)[1]);
  }
  return found;
}

TEST_F(ReportPage, NeedsNothingFromElsewhere) {
  const std::string page = Page();
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("http")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
  for (const std::string& target : AllOf(page, "(?:href|src)=\"([^\"]{0,40})")) {
    const bool is_here = target.starts_with("#") || target.starts_with("data:");
    EXPECT_TRUE(is_here || target == "report.json" || target == "answers.csv") << target;
  }
}

TEST_F(ReportPage, LinksLeadToPlacesOnThePage) {
  const std::string page = Page();
  const std::set<std::string> ids = AllOf(page, "id=\"([^\"]+)\"");
  const std::set<std::string> links = AllOf(page, "href=\"#([^\"]+)\"");
  EXPECT_GT(links.size(), 12u);
  for (const std::string& link : links) {
    EXPECT_TRUE(ids.count(link)) << link;
  }
}

TEST_F(ReportPage, RowsOfTheWorstFollowTheFirstTwoThousand) {
  const Localizer localizer = Localizer::Open(map_path_);
  queries_.front().query.features = {};  // 2,000 copies of them would take memory.
  queries_.resize(2003, queries_.front());
  report_ = Evaluate(queries_, [](const EvalQuery&) { return LocalizeResult{}; }, {});
  LocalizeResult wrong;
  wrong.localized = true;
  wrong.cam_from_ecef = queries_.back().cam_from_ecef;
  report_.answers.back().result = wrong;
  report_.answers.back().position_error_m = 50.0;
  report_.answers.back().rotation_error_rad = 0.0;
  const std::string page = MakeReportPage("map", localizer.map().Snapshot(), queries_, report_);
  EXPECT_THAT(page, HasSubstr("<figure id=\"w2002\""));
  EXPECT_THAT(page, HasSubstr("<tr id=\"q2002\""));
  EXPECT_THAT(page, Not(HasSubstr("<tr id=\"q2001\"")));
  EXPECT_THAT(page, HasSubstr("The first 2000 of 2003 queries and the worst"));
}

TEST_F(ReportPage, ShowsPlanCurvesCalibrationTimesAndTheTenWorst) {
  const std::string page = Page();
  EXPECT_THAT(page, HasSubstr("Version 2 of the map"));
  EXPECT_EQ(AllOf(page, "<figure id=\"(w[0-9]+)\"").size(), 10u);
  EXPECT_EQ(AllOf(page, "<tr id=\"(q[0-9]+)\"").size(), queries_.size());
  EXPECT_EQ(AllOf(page, "<a class=\"[a-z]+\" href=\"#(q[0-9]+)\"").size(), queries_.size());
  for (const char* title : {"Recall over position error", "Precision over recall", "Confidence",
                            "Stated accuracy", "Times by stage"}) {
    EXPECT_THAT(page, HasSubstr(title));
  }
  EXPECT_THAT(page, HasSubstr("class=\"band s1\""));
  EXPECT_THAT(page, HasSubstr("prefers-color-scheme: dark"));
}

TEST_F(ReportPage, NamesFromOutsideStayText) {
  queries_[0].name = "<img src=x onerror=alert(1)>\x1b[2J\"'&";
  const std::string page = Page();
  EXPECT_THAT(page, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(page, Not(HasSubstr("\x1b")));
  EXPECT_THAT(page, HasSubstr("map &lt;one&gt;"));
}

TEST_F(ReportPage, OfAnswersWithoutPosesAndLostPhotosIsWhole) {
  for (EvalQuery& query : queries_) {
    query.query.features.keypoints.clear();
    query.query.features.descriptors.resize(0, query.query.features.descriptors.cols());
    query.image_path = dir_.File("gone.jpg");
  }
  const std::string page = Page();
  EXPECT_EQ(report_.num_localized, 0);
  EXPECT_THAT(page, HasSubstr("gone.jpg"));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
  EXPECT_THAT(page, HasSubstr("</html>"));
}

TEST_F(ReportPage, OfNoQueriesIsWhole) {
  queries_.clear();
  EXPECT_THAT(Page(), HasSubstr("0 of 0 queries localized"));
}

}  // namespace
}  // namespace cairn::testing
