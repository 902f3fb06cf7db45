#include "mapping/matching/correct_focals.h"

#include <gtest/gtest.h>

#include "core/focal_length.h"
#include "mapping/facade_views.h"

namespace cairn {
namespace {

const std::vector<testing::FacadePhoto> kWalk = {{-8.0, 0.0}, {-3.0, 4.0}, {0.0, -6.0},
                                                 {4.0, 0.0},  {9.0, 2.0},  {12.0, -3.0}};

// All photos have EXIF. That of photo i is `exif_factors[i]` times the truth.
testing::FacadeViews WithExif(const std::vector<double>& exif_factors) {
  testing::FacadeViews world = testing::MakeFacadeViews(kWalk, [](int, int, int) { return true; });
  for (size_t i = 0; i < world.set.cameras.size(); ++i) {
    MappingCamera& camera = world.set.cameras[i];
    camera = {WithFocalScaled(camera.camera, exif_factors[i]), FocalPrior{.log_sigma = 0.05},
              FocalSource::kExif};
  }
  return world;
}

std::vector<MappingCamera> Corrected(const testing::FacadeViews& world, int num_threads) {
  return CorrectFocals(world.set, world.views, num_threads).value_or(world.set.cameras);
}

double RelativeFocal(const PhotoSet& set, const std::vector<MappingCamera>& found, size_t camera) {
  return found[camera].camera.focal_px() / set.cameras[camera].camera.focal_px();
}

TEST(CorrectFocals, FindsTheOnePhotoThatWasCropped) {
  const testing::FacadeViews world = WithExif({1.0, 0.97, 0.5, 1.0, 1.04, 1.0});
  const std::vector<MappingCamera> found = Corrected(world, 1);
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].source, i == 2 ? FocalSource::kPhotos : FocalSource::kExif) << i;
    EXPECT_NEAR(RelativeFocal(world.set, found, i), i == 2 ? 2.0 : 1.0, i == 2 ? 0.1 : 0.0) << i;
  }
}

TEST(CorrectFocals, FindsThatAllPhotosOfACameraWereEnlarged) {
  testing::FacadeViews world = WithExif({1.6, 1.6, 1.6, 1.6, 1.6, 1.6});
  for (MappingPhoto& photo : world.set.photos) {
    photo.camera_idx = 0;
  }
  const std::vector<MappingCamera> found = Corrected(world, 1);
  EXPECT_EQ(found[0].source, FocalSource::kPhotos);
  EXPECT_NEAR(RelativeFocal(world.set, found, 0), 1.0 / 1.6, 0.07);
  const std::vector<MappingCamera> again = Corrected(world, 3);
  EXPECT_EQ(found[0].camera.params(), again[0].camera.params());
}

TEST(CorrectFocals, KeepsWhatIsRoundedAndWhatFewViewsContradict) {
  testing::FacadeViews world = WithExif({1.1, 0.92, 1.0, 1.2, 1.0, 0.5});
  std::erase_if(world.views, [](const TwoView& view) { return view.b == 5 && view.a > 1; });
  EXPECT_FALSE(CorrectFocals(world.set, world.views, 1).has_value());
}

}  // namespace
}  // namespace cairn
