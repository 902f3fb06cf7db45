#include "mapping/growth/grown_focals.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

// Two cameras of unknown lenses, the first with twelve photos, the second with three.
struct World {
  PhotoSet set;
  std::vector<Segment> segments{1};

  World() {
    set.cameras.resize(2, {CameraOfUnknownFocal(640, 480), {}, FocalSource::kGuess});
    for (const MappingCamera& camera : set.cameras) {
      segments[0].model.cameras.push_back(camera.camera);
    }
    for (int i = 0; i < 15; ++i) {
      ReconImage image;
      image.camera_idx = i < 12 ? 0 : 1;
      segments[0].model.images.push_back(image);
      segments[0].photo_of_image.push_back(i);
    }
  }

  void Grow(int camera, double factor) {
    segments[0].model.cameras[camera] = WithFocalScaled(set.cameras[camera].camera, factor);
  }
};

TEST(GrownFocals, TakesFromManyPhotosWhatHasMovedFar) {
  World world;
  world.Grow(0, 0.76);
  world.Grow(1, 0.76);
  const auto cameras = GrownFocals(world.set, world.segments);
  ASSERT_TRUE(cameras);
  const MappingCamera &moved = (*cameras)[0], &guess = world.set.cameras[0];
  EXPECT_NEAR(moved.camera.focal_px(), 0.76 * guess.camera.focal_px(), 1e-9);
  EXPECT_EQ(moved.source, FocalSource::kGrowth);
  EXPECT_LT(moved.focal.log_sigma, guess.focal.log_sigma);
  // Three photos tell little.
  EXPECT_EQ((*cameras)[1].camera.params(), world.set.cameras[1].camera.params());
  EXPECT_EQ((*cameras)[1].source, FocalSource::kGuess);
}

TEST(GrownFocals, LeavesWhatHasMovedLittleAndWhatIsKnown) {
  World world;
  EXPECT_FALSE(GrownFocals(world.set, {}));
  world.Grow(0, 1.08);
  EXPECT_FALSE(GrownFocals(world.set, world.segments));
  world.Grow(0, 0.76);
  for (const FocalSource source : {FocalSource::kExif, FocalSource::kCalibration}) {
    world.set.cameras[0].source = source;
    EXPECT_FALSE(GrownFocals(world.set, world.segments));
  }
}

// The focal length has not moved, but the corners are 15 % farther out than without distortion.
TEST(GrownFocals, ADistortionThatNoLensHasMeansAShorterFocalLength) {
  World world;
  const Camera& guess = world.set.cameras[0].camera;
  const double focal_px = guess.focal_px();
  const double sq_radius = (320.0 * 320.0 + 240.0 * 240.0) / (focal_px * focal_px);
  const auto grow_with_k1 = [&](double k1) {
    world.segments[0].model.cameras[0] =
        Camera(CameraModel::kSimpleRadial, 640, 480, {focal_px, 320.0, 240.0, k1});
  };
  grow_with_k1(0.03 / sq_radius);
  EXPECT_FALSE(GrownFocals(world.set, world.segments));
  grow_with_k1(-0.15 / sq_radius);  // Wide lenses do this.
  EXPECT_FALSE(GrownFocals(world.set, world.segments));
  grow_with_k1(0.15 / sq_radius);
  const auto cameras = GrownFocals(world.set, world.segments);
  ASSERT_TRUE(cameras);
  EXPECT_NEAR((*cameras)[0].camera.focal_px(), focal_px / 1.5, 1e-9);
}

TEST(GrownFocals, TheSegmentWithMostPhotosOfTheCameraDecides) {
  World world;
  world.Grow(0, 0.76);
  world.segments.push_back(world.segments[0]);
  world.Grow(0, 1.5);
  world.segments[1].model.images.resize(11);
  const auto cameras = GrownFocals(world.set, world.segments);
  ASSERT_TRUE(cameras);
  EXPECT_NEAR((*cameras)[0].camera.focal_px(), 1.5 * world.set.cameras[0].camera.focal_px(), 1e-9);
}

}  // namespace
}  // namespace cairn
