#include "cli/rig_photos.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

class RigPhotosTest : public ::testing::Test {
 protected:
  RigPhotosTest() { Write("left.pgm", "P5\n4 2\n255\n12345678"); }

  void Write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << content;
  }
  std::vector<RigPhoto> Read(const std::string& json) const {
    Write("rig.json", json);
    return ReadRigPhotos((folder_.path() / "rig.json").string());
  }
  // What is wrong with the file.
  std::string Refusal(const std::string& json) const {
    try {
      Read(json);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }

  static std::string Element(int width_px, const std::string& image, double x_m) {
    return fmt::format(
        R"({{"camera":{{"model":"PINHOLE","size":[{},2],"modelParams":[3,3,2,1]}},
            "camFromFirst":{{"quaternion":{{"x":0,"y":0.6,"z":0,"w":0.8}},"translation":[{},0,0]}},
            "image":"{}"}})",
        width_px, x_m, image);
  }

 private:
  testing::TempDir folder_;
};

TEST_F(RigPhotosTest, ReadsCamerasAndTheirPhotosBesideTheFile) {
  const std::vector<RigPhoto> photos =
      Read(fmt::format("[{},{}]", Element(4, "left.pgm", 0.5), Element(4, "left.pgm", -0.5)));
  ASSERT_EQ(photos.size(), 2u);
  EXPECT_EQ(photos[1].camera.cam_from_first.translation, Eigen::Vector3d(-0.5, 0, 0));
  EXPECT_EQ(photos[1].camera.camera.width_px(), 4);
  EXPECT_EQ(photos[1].photo.image.pixels[7], '8');
  EXPECT_EQ(photos[1].photo.bytes.size(), 19u);
}

TEST_F(RigPhotosTest, SaysWhatIsWrong) {
  EXPECT_THAT(Refusal("[]"), HasSubstr("1 to 7"));
  EXPECT_THAT(Refusal("[{}]"), HasSubstr("/0/camera"));
  EXPECT_THAT(Refusal("[{\"features\":1}]"), HasSubstr("features"));
  EXPECT_THAT(Refusal(fmt::format("[{}]", Element(4, "left.pgm", 200.0))),
              HasSubstr("/0/camFromFirst/translation"));
  EXPECT_THAT(Refusal(fmt::format("[{}]", Element(5, "left.pgm", 0.0))), HasSubstr("4 x 2"));
  EXPECT_THAT(Refusal(fmt::format("[{}]", Element(4, "right.pgm", 0.0))), HasSubstr("right.pgm"));
  EXPECT_THAT(Refusal(fmt::format("[{}]", Element(4, "rig.json", 0.0))), HasSubstr("rig.json"));
}

}  // namespace
}  // namespace cairn
