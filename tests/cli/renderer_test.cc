#include "cli/demo/street/renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace cairn {
namespace {

constexpr double kDark = 40.0;
constexpr double kBright = 220.0;
const PhotoEffects kNoEffects = {1.0, 0.0, 0.0, 0};

Camera SmallCamera() { return {CameraModel::kPinhole, 320, 240, {210.0, 205.0, 158.0, 121.0}}; }

std::shared_ptr<const Texture> PlainTexture(double gray) {
  return std::make_shared<const Texture>(cv::Mat(64, 64, CV_8UC1, cv::Scalar(gray)));
}

// A 4 m x 4 m wall in the plane y = 0, seen from y < 0, dark but for a bright square of 0.25 m
// whose center is at (x, z) = (0.625, 1.125).
TexturedRect WallWithMark() {
  cv::Mat pixels(512, 512, CV_8UC1, cv::Scalar(kDark));
  pixels(cv::Rect(256 + 76, 512 - 148, 8, 8)).setTo(cv::Scalar(kBright));
  return {
      {-2.0, 0.0, 4.0}, {4.0, 0.0, 0.0}, {0.0, 0.0, -4.0}, std::make_shared<const Texture>(pixels)};
}
const Eigen::Vector3d kMarkInEnu(0.625, 0.0, 1.125);

// A camera at `center` that looks at `target`.
Rigid3d LookAt(const Eigen::Vector3d& center, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - center).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d cam_from_enu;
  cam_from_enu << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  return {cam_from_enu, -(cam_from_enu * center)};
}

// Center of the light above the wall's gray near a pixel, in our pixel convention.
Eigen::Vector2d MarkNear(const Eigen::Vector2d& pixel, const GrayImage& image) {
  constexpr int kRadiusPx = 15;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight_sum = 0.0;
  for (int y = static_cast<int>(pixel.y()) - kRadiusPx; y <= pixel.y() + kRadiusPx; ++y) {
    for (int x = static_cast<int>(pixel.x()) - kRadiusPx; x <= pixel.x() + kRadiusPx; ++x) {
      const double weight = image.pixels[y * image.width_px + x] - kDark;
      sum += weight * Eigen::Vector2d(x + 0.5, y + 0.5);
      weight_sum += weight;
    }
  }
  return sum / weight_sum;
}

TEST(Renderer, ShowsTheMarkWhereTheCameraProjectsIt) {
  const Renderer renderer({WallWithMark()});
  const Camera camera = SmallCamera();
  // Straight, oblique, from above and below.
  for (const Eigen::Vector3d& center :
       {Eigen::Vector3d(0.5, -1.3, 1.4), Eigen::Vector3d(0.1, -1.2, 1.7),
        Eigen::Vector3d(0.9, -1.3, 1.9), Eigen::Vector3d(0.4, -1.4, 1.2)}) {
    const Rigid3d cam_from_enu = LookAt(center, {0.5, 0.0, 1.5});
    const GrayImage image = renderer.Render(camera, cam_from_enu, kNoEffects);
    const Eigen::Vector2d expected = *camera.Project(cam_from_enu * kMarkInEnu);
    EXPECT_LT((MarkNear(expected, image) - expected).norm(), 0.1) << center.transpose();
  }
}

TEST(Renderer, AgreesWithRayCastingAboutWhatIsSky) {
  // The wall, and ground that reaches behind the camera.
  const TexturedRect ground = {
      {-30.0, 30.0, 0.0}, {60.0, 0.0, 0.0}, {0.0, -60.0, 0.0}, PlainTexture(100.0)};
  const Renderer renderer({WallWithMark(), ground});
  const Camera camera = SmallCamera();
  const Rigid3d cam_from_enu = LookAt({1.0, -6.0, 1.5}, {-1.0, 2.0, 2.5});
  const GrayImage image = renderer.Render(camera, cam_from_enu, kNoEffects);
  const Rigid3d enu_from_cam = cam_from_enu.Inverse();
  int num_sky = 0, num_wrong = 0;
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      const Eigen::Vector3d ray = enu_from_cam.rotation * *camera.Unproject({x + 0.5, y + 0.5});
      const bool expected_sky = std::isinf(renderer.FreeSightM(enu_from_cam.translation, ray));
      const bool is_sky = image.pixels[y * image.width_px + x] > 200;
      num_sky += is_sky ? 1 : 0;
      num_wrong += is_sky != expected_sky ? 1 : 0;
    }
  }
  EXPECT_GT(num_sky, 5000);
  // Only pixels on borders may differ; the bright mark covers some more.
  EXPECT_LT(num_wrong, 500);
}

TEST(Renderer, NearerRectanglesHideFartherOnes) {
  TexturedRect near_wall = WallWithMark(), far_wall = WallWithMark();
  near_wall.texture = PlainTexture(90.0);
  far_wall.texture = PlainTexture(150.0);
  far_wall.corner_in_enu.y() = 1.0;
  const Rigid3d cam_from_enu = LookAt({0.0, -1.0, 2.0}, {0.0, 0.0, 2.0});
  for (const auto& rects : {std::vector{near_wall, far_wall}, std::vector{far_wall, near_wall}}) {
    const GrayImage image = Renderer(rects).Render(SmallCamera(), cam_from_enu, kNoEffects);
    EXPECT_EQ(image.pixels[120 * 320 + 160], 90);
  }
}

TEST(Renderer, RectanglesHaveNoBack) {
  const Renderer renderer({WallWithMark()});
  const GrayImage image =
      renderer.Render(SmallCamera(), LookAt({0.0, 3.0, 2.0}, {0.0, 0.0, 2.0}), kNoEffects);
  for (const uint8_t pixel : image.pixels) {
    ASSERT_GT(pixel, 200);  // Sky.
  }
}

TEST(Renderer, FiltersFineTexturesToTheirMean) {
  // Stripes of one texel, far below the pixel size: no aliasing is left of them.
  cv::Mat stripes(512, 512, CV_8UC1);
  for (int x = 0; x < stripes.cols; ++x) {
    stripes.col(x).setTo(cv::Scalar(x % 2 ? 200.0 : 50.0));
  }
  TexturedRect wall = WallWithMark();
  wall.texture = std::make_shared<const Texture>(stripes);
  const GrayImage image =
      Renderer({wall}).Render(SmallCamera(), LookAt({0.0, -6.0, 2.0}, {0.0, 0.0, 2.0}), kNoEffects);
  for (int x = 120; x < 200; ++x) {
    EXPECT_NEAR(image.pixels[120 * 320 + x], 125, 3);
  }
}

TEST(Renderer, AppliesExposureVignettingAndNoise) {
  TexturedRect wall = WallWithMark();
  wall.texture = PlainTexture(100.0);
  const Renderer renderer({wall});
  const Rigid3d cam_from_enu = LookAt({0.0, -0.5, 2.0}, {0.0, 0.0, 2.0});
  const auto render = [&](const PhotoEffects& effects) {
    return renderer.Render(SmallCamera(), cam_from_enu, effects);
  };
  EXPECT_EQ(render({1.5, 0.0, 0.0, 0}).pixels[120 * 320 + 160], 150);
  const GrayImage vignetted = render({1.0, 0.4, 0.0, 0});
  EXPECT_EQ(vignetted.pixels[120 * 320 + 160], 100);
  EXPECT_NEAR(vignetted.pixels[0], 60, 1);

  const GrayImage noisy = render({1.0, 0.0, 3.0, 1});
  double sum = 0.0, sum_of_squares = 0.0;
  for (const uint8_t pixel : noisy.pixels) {
    sum += pixel - 100.0;
    sum_of_squares += (pixel - 100.0) * (pixel - 100.0);
  }
  const double count = static_cast<double>(noisy.pixels.size());
  EXPECT_NEAR(sum / count, 0.0, 0.1);
  EXPECT_NEAR(std::sqrt(sum_of_squares / count), 3.0, 0.1);
  EXPECT_EQ(noisy.pixels, render({1.0, 0.0, 3.0, 1}).pixels);
  EXPECT_NE(noisy.pixels, render({1.0, 0.0, 3.0, 2}).pixels);
}

}  // namespace
}  // namespace cairn
