// Tests the requirement on real phone photos. Every fourth photo is a query, the others
// make the map.
#include <gtest/gtest.h>

#include <vector>

#include "core/angles.h"
#include "core/keypoint_shape.h"
#include "core/statistics.h"
#include "support/cut_out.h"
#include "support/test_data.h"
#include "system/real_drive.h"

namespace cairn::testing {
namespace {

class LundStreet : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!std::filesystem::exists(TestDataDir() / "street_lund")) {
      return;
    }
    RealDriveInput input = LundInput();
    input.is_query = [](const std::string& name) { return std::stoi(name) % 4 == 0; };
    street_ = new RealDrive(input);
  }
  static void TearDownTestSuite() {
    delete street_;
    street_ = nullptr;
  }
  void SetUp() override { CAIRN_SKIP_WITHOUT_DATA("street_lund"); }

  static RealDrive* street_;
};
RealDrive* LundStreet::street_ = nullptr;

TEST_F(LundStreet, LocalizesHeldOutPhotos) {
  const EvalReport report = street_->Run(QueryRoute::kInProcessFeatures);
  EXPECT_EQ(report.num_queries, 7);
  int num_correct = 0;
  for (const EvalAnswer& answer : report.answers) {
    num_correct += answer.position_error_m <= 3.0 && answer.rotation_error_rad <= 10 * kRadPerDeg;
  }
  EXPECT_GE(num_correct, 6);
  EXPECT_LE(report.median_position_error_m.value, 0.1);
  EXPECT_LE(report.median_rotation_error_rad.value, 0.2 * kRadPerDeg);
}

// As the keypoints of learned features: places and descriptors alone.
TEST_F(LundStreet, NeedsNeitherSizesNorOrientations) {
  for (EvalQuery query : street_->queries()) {
    const LocalizeResult whole = street_->localizer().Localize(query.query);
    for (Keypoint& keypoint : query.query.features.keypoints) {
      keypoint = KeypointWithoutShape(keypoint.x_px, keypoint.y_px);
    }
    const LocalizeResult points = street_->localizer().Localize(query.query);
    EXPECT_EQ(points.localized, whole.localized) << query.name;
    if (points.localized && whole.localized) {
      EXPECT_LT(PositionDifferenceM(points, whole), 0.3) << query.name;
    }
  }
}

TEST_F(LundStreet, NeedsNoFocalLength) {
  const EvalReport known = street_->Run(QueryRoute::kInProcessFeatures);
  const EvalReport unknown = street_->Run(QueryRoute::kInProcessFeatures, {.withheld = true});
  EXPECT_GE(unknown.num_localized, known.num_localized);
  EXPECT_LE(unknown.median_position_error_m.value, 0.3);
}

// Parts of photos without a camera, as people send them.
TEST_F(LundStreet, LocalizesPartsOfPhotos) {
  std::vector<double> errors_m;
  for (const Part& part :
       {Part{.right = 0.7}, Part{.left = 0.3}, Part{.right = 0.7, .bottom = 0.7}}) {
    for (const EvalQuery& query : street_->queries()) {
      const LocalizeResult whole = street_->localizer().Localize(query.query);
      const LocalizeResult cut_out = street_->localizer().Localize(CutOut(query.query, part));
      if (whole.localized && cut_out.localized) {
        errors_m.push_back(PositionDifferenceM(cut_out, whole));
      }
    }
  }
  EXPECT_GE(errors_m.size(), 18u);
  EXPECT_LE(Median(errors_m), 0.2);
}

TEST_F(LundStreet, ServerAnswersFeaturesAsTheLibraryDoes) {
  const EvalReport library = street_->Run(QueryRoute::kInProcessFeatures);
  const EvalReport server = street_->Run(QueryRoute::kServerFeatures);
  ASSERT_EQ(server.num_localized, library.num_localized);
  for (int i = 0; i < library.num_queries; ++i) {
    ASSERT_EQ(library.answers[i].result.localized, server.answers[i].result.localized);
    if (library.answers[i].result.localized) {
      EXPECT_LT(PositionDifferenceM(library.answers[i].result, server.answers[i].result), 0.05);
    }
  }
}

TEST_F(LundStreet, ServerAnswersPhotosAsTheLibraryDoes) {
  const EvalReport library = street_->Run(QueryRoute::kInProcessImage);
  const EvalReport server = street_->Run(QueryRoute::kServerImage);
  EXPECT_GE(library.num_localized, 5);
  ASSERT_EQ(server.num_localized, library.num_localized);
  for (int i = 0; i < library.num_queries; ++i) {
    if (library.answers[i].result.localized) {
      EXPECT_LT(PositionDifferenceM(library.answers[i].result, server.answers[i].result), 1e-6);
    }
  }
}

}  // namespace
}  // namespace cairn::testing
