#include "fusion/start/starter.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace cairn::fusion {
namespace {

constexpr int64_t kFrameStepNs = 100'000'000;
constexpr int64_t kSampleStepNs = 5'000'000;

// A device that rests, in front of features that move by `pixels_per_frame`. No start in motion.
class RestingDevice {
 public:
  // Whether the starter has started, with this frame.
  bool AddFrame(double pixels_per_frame) {
    for (; next_sample_ns_ <= next_frame_ns_; next_sample_ns_ += kSampleStepNs) {
      imu_.Push({next_sample_ns_, {0.001, 0.0, 0.0}, {0.0, 0.0, 9.81}});
    }
    std::vector<TrackedFeature> features;
    shift_px_ += pixels_per_frame;
    for (uint64_t id = 0; id < 30; ++id) {
      features.push_back({id, {100.0 + 10.0 * static_cast<double>(id) + shift_px_, 200.0}});
    }
    start_ = starter_.AddFrame(++frame_id_, next_frame_ns_, features, imu_);
    next_frame_ns_ += kFrameStepNs;
    return start_.has_value();
  }

  const StartState& start() const { return *start_; }

 private:
  static StarterOptions Options() {
    StarterOptions options;
    options.camera = Camera(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0});
    options.dynamic_start.enabled = false;
    return options;
  }

  Starter starter_{Options()};
  ImuBuffer imu_{4096};
  int64_t next_sample_ns_ = 0;
  int64_t next_frame_ns_ = 0;
  int64_t frame_id_ = 0;
  double shift_px_ = 0.0;
  std::optional<StartState> start_;
};

TEST(Starter, StartsAfterASecondOfRest) {
  RestingDevice device;
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(device.AddFrame(0.0)) << i;
  }
  ASSERT_TRUE(device.AddFrame(0.0));
  EXPECT_NEAR(device.start().imu.gyro_bias.x(), 0.001, 1e-6);
  EXPECT_EQ(device.start().imu.velocity_in_local.norm(), 0.0);
}

// As in a train.
TEST(Starter, DoesNotTakeQuietReadingsForRestIfTracksMove) {
  RestingDevice device;
  for (int i = 0; i < 30; ++i) {
    EXPECT_FALSE(device.AddFrame(3.0)) << i;
  }
}

TEST(Starter, StartsOnceTheTracksHaveComeToRest) {
  RestingDevice device;
  for (int i = 0; i < 20; ++i) {
    ASSERT_FALSE(device.AddFrame(3.0)) << i;
  }
  int num_frames = 1;
  while (!device.AddFrame(0.0) && num_frames < 30) {
    ++num_frames;
  }
  EXPECT_GE(num_frames, 9);  // A second, but for the 2.5 px that are allowed.
  EXPECT_LE(num_frames, 11);
}

TEST(Starter, BeginsAnewAfterAStart) {
  RestingDevice device;
  for (int i = 0; i < 10; ++i) {
    ASSERT_FALSE(device.AddFrame(0.0));
  }
  ASSERT_TRUE(device.AddFrame(0.0));
  // The first frame after has none to be compared with.
  EXPECT_TRUE(device.AddFrame(100.0));
}

}  // namespace
}  // namespace cairn::fusion
