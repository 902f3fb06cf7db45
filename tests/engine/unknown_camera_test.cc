// Tests the whole engine with uncalibrated cameras.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/camera_of_this_size.h"
#include "core/error.h"
#include "engine/find_camera.h"
#include "engine/mapped_streets.h"
#include "engine/pose/focal_search.h"
#include "support/cut_out.h"

namespace cairn {
namespace {

using testing::CutOut;
using testing::ExpectPose;
using testing::Part;
using testing::QueryAt;
using testing::QueryPose;

class UnknownCamera : public testing::OneStreetTest {
 protected:
  // A query whose camera is said to have `factor` times its focal length.
  static LocalizeQuery Asked(double factor, std::optional<double> log_sigma) {
    LocalizeQuery query = QueryAt(*world_, Truth());
    query.camera = WithFocalScaled(query.camera, factor);
    if (log_sigma) {
      query.focal = FocalPrior{.log_sigma = *log_sigma};
    }
    return query;
  }
  static LocalizeQuery Withheld() {
    LocalizeQuery query = QueryAt(*world_, Truth());
    query.camera = CameraOfUnknownFocal(query.camera.width_px(), query.camera.height_px());
    query.focal = FocalPrior{.with_distortion = true};
    return query;
  }
  static Rigid3d Truth() { return QueryPose(20.0); }
  static void ExpectCamera(const LocalizeResult& result) {
    ASSERT_TRUE(result.camera);
    const double focal_px = world_->camera().focal_px();
    EXPECT_NEAR(result.camera->camera.focal_px(), focal_px, 0.01 * focal_px);
    EXPECT_LT(result.camera->focal_sigma_px, 0.01 * focal_px);
  }
};

TEST_F(UnknownCamera, IsEstimatedWithThePose) {
  const LocalizeResult result = map_->localizer().Localize(Withheld());
  ExpectPose(result, *world_, Truth(), 0.1, 0.2 * kRadPerDeg);
  ExpectCamera(result);
  EXPECT_FALSE(result.camera->focal_disagrees);
  EXPECT_FALSE(result.camera->is_off_center);
  EXPECT_NEAR(result.camera->assumed_focal_px, 0.85 * 640, 1e-9);
  for (const LocalizeMatch& match : result.matches) {
    const auto pixel = result.camera->camera.Project(result.cam_from_anchor * match.x_in_anchor);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR((*pixel - match.pixel).norm(), match.traits.error_px, 1e-9);
  }
}

TEST_F(UnknownCamera, NeedsNoGravity) {
  LocalizeQuery query = Withheld();
  query.down_in_cam.reset();
  const LocalizeResult result = map_->localizer().Localize(query);
  ExpectPose(result, *world_, Truth(), 0.1, 0.2 * kRadPerDeg);
  ExpectCamera(result);
}

TEST_F(UnknownCamera, MayHaveAnUncertainFocalLength) {
  for (const double factor : {0.8, 0.95, 1.05, 1.25}) {
    const LocalizeResult result = map_->localizer().Localize(Asked(factor, 0.15));
    ExpectPose(result, *world_, Truth(), 0.1, 0.2 * kRadPerDeg);
    ExpectCamera(result);
    EXPECT_FALSE(result.camera->focal_disagrees);
  }
}

TEST_F(UnknownCamera, ContradictsAFocalLengthThatIsWrong) {
  for (const double factor : {0.9, 0.95, 1.05, 1.1}) {
    const LocalizeResult result = map_->localizer().Localize(Asked(factor, std::nullopt));
    ExpectPose(result, *world_, Truth(), 0.2, 0.3 * kRadPerDeg);
    ExpectCamera(result);
    EXPECT_TRUE(result.camera->focal_disagrees);
  }
}

TEST_F(UnknownCamera, LeavesAFocalLengthThatIsRight) {
  const LocalizeResult result = map_->localizer().Localize(Asked(1.0, std::nullopt));
  ExpectPose(result, *world_, Truth(), 0.05, 0.1 * kRadPerDeg);
  EXPECT_FALSE(result.camera);
}

TEST_F(UnknownCamera, IsTheSameOnAnyNumberOfThreads) {
  LocalizerOptions options;
  options.num_threads = 4;
  const LocalizeResult one = map_->localizer().Localize(Withheld());
  const LocalizeResult four = map_->WithOptions(options).Localize(Withheld());
  EXPECT_EQ(one.cam_from_anchor.ToMatrix(), four.cam_from_anchor.ToMatrix());
}

TEST_F(UnknownCamera, IsNoCameraOfARig) {
  LocalizeQuery query = Withheld();
  query.other_cameras.push_back({world_->camera(), Rigid3d(), {}});
  EXPECT_THROW(map_->localizer().Localize(query), Error);
}

// A photo sent at another size than its camera's parameters are for, or turned.
TEST_F(UnknownCamera, ParametersOfAnotherSizeOfThePictureAreRecognized) {
  const LocalizeQuery right = QueryAt(*world_, Truth());
  const int width_px = right.camera.width_px(), height_px = right.camera.height_px();
  const double focal_px = right.camera.focal_px();
  for (const double factor : {0.5, 0.75, 1.3, 1.5, 2.0, 3.9375}) {
    LocalizeQuery query = right;
    query.camera = Camera(CameraModel::kSimplePinhole, width_px, height_px,
                          {factor * focal_px, factor * 0.5 * width_px, factor * 0.5 * height_px});
    const LocalizeResult result = map_->localizer().Localize(query);
    SCOPED_TRACE(factor);
    ExpectPose(result, *world_, Truth(), 0.1, 0.2 * kRadPerDeg);
    ASSERT_TRUE(result.camera);
    EXPECT_NEAR(result.camera->camera.focal_px(), focal_px, 0.01 * focal_px);
    EXPECT_TRUE(result.camera->focal_disagrees);
    EXPECT_NEAR(result.camera->assumed_focal_px, factor * focal_px, 1e-9);
  }
  LocalizeQuery turned = right;
  turned.camera = Camera(CameraModel::kSimplePinhole, width_px, height_px,
                         {focal_px, 0.5 * height_px, 0.5 * width_px});
  const LocalizeResult result = map_->localizer().Localize(turned);
  ExpectPose(result, *world_, Truth(), 0.1, 0.2 * kRadPerDeg);
  ASSERT_TRUE(result.camera && result.camera->focal_disagrees);
  EXPECT_TRUE(HasAxesExchanged(turned.camera, result.camera->camera));
  EXPECT_FALSE(HasAxesExchanged(right.camera, result.camera->camera));
}

// The upper left part of a picture has its principal point on the diagonal, too.
TEST_F(UnknownCamera, ACropWithItsOwnParametersIsAnsweredAsStated) {
  const LocalizeQuery whole = QueryAt(*world_, Truth());
  LocalizeQuery query = CutOut(whole, {.right = 0.7, .bottom = 0.7});
  query.camera = Camera(whole.camera.model(), query.camera.width_px(), query.camera.height_px(),
                        whole.camera.params());
  query.focal.reset();
  ASSERT_TRUE(CameraOfThisSize(query.camera));
  const LocalizeResult result = map_->localizer().Localize(query);
  ExpectPose(result, *world_, Truth(), 0.1, 0.2 * kRadPerDeg);
  EXPECT_FALSE(result.camera);
}

// Far off, and said to be certain: so far off that all of the freedom of the focal length is
// needed.
TEST_F(UnknownCamera, AWrongFocalLengthIsNoPartOfAPhoto) {
  for (const double factor : {0.65, 0.8, 1.25, 1.4}) {
    const LocalizeResult result = map_->localizer().Localize(Asked(factor, 0.01));
    EXPECT_FALSE(result.camera && result.camera->is_off_center) << factor;
  }
}

// As people crop photos before they send them.
TEST_F(UnknownCamera, APartOfAPhotoIsRecognizedAsThat) {
  const LocalizeQuery whole = QueryAt(*world_, Truth());
  const Eigen::Vector2d axis_px = PrincipalPointPx(whole.camera);
  const double width_px = whole.camera.width_px(), height_px = whole.camera.height_px();
  for (const Part& part :
       {Part{.right = 0.7}, Part{.left = 0.35}, Part{.top = 0.3, .right = 0.7}}) {
    SCOPED_TRACE(part.left);
    LocalizeQuery query = CutOut(whole, part);
    const Eigen::Vector2d corner_px(part.left * width_px, part.top * height_px);
    // The focal length in an EXIF is that of the whole photo, in shares of the long side.
    const Camera of_exif(CameraModel::kSimplePinhole, query.camera.width_px(),
                         query.camera.height_px(),
                         {whole.camera.focal_px() * query.camera.width_px() / width_px,
                          0.5 * query.camera.width_px(), 0.5 * query.camera.height_px()});
    for (const bool has_exif : {false, true}) {
      if (has_exif) {
        query.camera = of_exif;
        query.focal = FocalPrior{.log_sigma = 0.05};
      }
      const LocalizeResult result = map_->localizer().Localize(query);
      ExpectPose(result, *world_, Truth(), 3.0 * result.position_accuracy_m,
                 3.0 * result.rotation_accuracy_rad);
      EXPECT_LT(result.position_accuracy_m, 0.4);
      ASSERT_TRUE(result.camera);
      EXPECT_TRUE(result.camera->is_off_center);
      EXPECT_EQ(result.camera->focal_disagrees, has_exif);
      EXPECT_LT((PrincipalPointPx(result.camera->camera) - (axis_px - corner_px)).norm(), 15.0);
    }
  }
}

TEST(CameraOfThisSize, IsNoneForPrincipalPointsNearTheMiddleOrOffTheDiagonals) {
  for (const auto& [x_px, y_px] :
       {std::pair(320.0, 240.0), std::pair(350.0, 255.0), std::pair(480.0, 240.0),
        std::pair(480.0, 290.0), std::pair(-10.0, 100.0)}) {
    EXPECT_FALSE(
        CameraOfThisSize(Camera(CameraModel::kSimplePinhole, 640, 480, {500.0, x_px, y_px})));
  }
}

TEST(FocalGuesses, AreOnlyWhatIsStatedIfThatIsCertain) {
  EXPECT_EQ(FocalGuesses({.log_sigma = 0.01}), std::vector<double>{1.0});
}

TEST(FocalGuesses, CoverThePriorLikeliestFirst) {
  const std::vector<double> guesses = FocalGuesses({.log_sigma = 0.25});
  EXPECT_EQ(guesses.front(), 1.0);
  EXPECT_NEAR(*std::min_element(guesses.begin(), guesses.end()), std::exp(-0.75), 1e-9);
  EXPECT_NEAR(*std::max_element(guesses.begin(), guesses.end()), std::exp(0.75), 1e-9);
  for (size_t i = 1; i < guesses.size(); ++i) {
    EXPECT_GE(std::abs(std::log(guesses[i])), std::abs(std::log(guesses[i - 1])) - 1e-9);
  }
}

TEST(FoundCamera, IsCertainWithEvidenceAndWithoutARival) {
  FoundCamera found{Camera(), 0.01, 100.0, 40.0};
  EXPECT_TRUE(found.IsCertain(90.0));
  EXPECT_FALSE(found.IsCertain(110.0));
  found.rival_evidence = 60.0;
  EXPECT_FALSE(found.IsCertain(90.0));
  found.rival_evidence = 0.0;
  found.focal_log_sigma = 0.05;
  EXPECT_FALSE(found.IsCertain(90.0));
}

}  // namespace
}  // namespace cairn
