#include "lab/experiments/measure/city_walks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "lab/rivals/fusion/comparison.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

class CityWalks : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const testing::TempDir folder;
    CityWalksOptions options;
    options.num_walks = 2;
    options.duration_s = 10.0;
    options.first_counted_s = 4.0;
    walks_ = new std::vector<fusion::Recording>(RecordCityWalks(options, folder.File("a"), {}));
  }
  static void TearDownTestSuite() { delete walks_; }

  static std::vector<fusion::Recording>* walks_;
};
std::vector<fusion::Recording>* CityWalks::walks_ = nullptr;

TEST_F(CityWalks, HaveSamplesFromFirstToLastFrameAndTracks) {
  ASSERT_EQ(walks_->size(), 2u);
  for (const fusion::Recording& walk : *walks_) {
    ASSERT_EQ(walk.frames.size(), 101u);
    EXPECT_LE(walk.imu.front().timestamp_ns, walk.frames.front().timestamp_ns);
    EXPECT_GE(walk.imu.back().timestamp_ns, walk.frames.back().timestamp_ns);
    EXPECT_GT(walk.frames.back().features.size(), 30u);
  }
  EXPECT_NE((*walks_)[0].frames.back().global_from_imu.translation,
            (*walks_)[1].frames.back().global_from_imu.translation);
}

// Half a pixel of noise on each axis; the phone's own lens is known to the tracker.
TEST_F(CityWalks, AnswersAreOfTheFramesThatWereAskedAbout) {
  size_t num_localized = 0, num_queried = 0;
  std::vector<double> errors_px, errors_m;
  for (const fusion::Recording& walk : *walks_) {
    for (size_t i = 0; i < walk.frames.size(); ++i) {
      const fusion::RecordedFrame& frame = walk.frames[i];
      if (i == 0 || i % 5 != 0) {
        EXPECT_FALSE(frame.answer.localized);
        continue;
      }
      ++num_queried;
      if (!frame.answer.localized) {
        continue;
      }
      ++num_localized;
      const Rigid3d cam_from_global =
          walk.options.rig.cam_from_imu * frame.global_from_imu.Inverse();
      errors_m.push_back(
          (frame.answer.global_from_cam.translation - cam_from_global.Inverse().translation)
              .norm());
      for (const fusion::MapMatch& match : frame.answer.matches) {
        const auto pixel = walk.options.camera.Project(cam_from_global * match.x_in_global);
        errors_px.push_back(pixel ? (*pixel - match.pixel).norm() : 1e9);
      }
    }
  }
  ASSERT_GT(3 * num_localized, num_queried);
  const auto median = [](std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
  };
  EXPECT_LT(median(errors_m), 1.0);
  EXPECT_LT(median(errors_px), 20.0);  // A map 0.3 m off, seen from ten meters.
}

TEST_F(CityWalks, CanBeComparedOn) {
  const auto results = fusion::CompareEstimators(walks_->front(), {});
  for (const fusion::MethodResult& result : results) {
    EXPECT_GT(result.num_counted_frames, 10u) << result.name;
    EXPECT_LT(result.position_rmse_m, 3.0) << result.name;
  }
}

}  // namespace
}  // namespace cairn
