#include "core/features/klt/klt_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace cairn::fusion {
namespace {

constexpr int kWidthPx = 320;
constexpr int kHeightPx = 240;

GrayView ViewOf(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<ptrdiff_t>(image.step)};
}

// Smooth random patches, larger than an image so that it can move.
cv::Mat Texture(uint64_t seed) {
  cv::Mat noise(kHeightPx + 80, kWidthPx + 80, CV_8UC1);
  cv::RNG rng(seed);
  rng.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, cv::Size(0, 0), 2.0);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  return noise;
}

// What the camera sees where image = warp * texture, in OpenCV's coordinates.
cv::Mat Warp(const cv::Mat& texture, const cv::Matx23d& image_from_texture) {
  cv::Mat image;
  cv::warpAffine(texture, image, image_from_texture, cv::Size(kWidthPx, kHeightPx),
                 cv::INTER_LINEAR, cv::BORDER_REFLECT);
  return image;
}

cv::Matx23d Shift(double x, double y) { return {1.0, 0.0, x - 40.0, 0.0, 1.0, y - 40.0}; }

std::map<uint64_t, Eigen::Vector2d> ById(std::span<const TrackedFeature> features) {
  std::map<uint64_t, Eigen::Vector2d> by_id;
  for (const TrackedFeature& feature : features) {
    by_id[feature.track_id] = feature.pixel;
  }
  return by_id;
}

// Median and largest distance of features seen in both from where `move` takes the first
// observation.
template <typename Move>
std::pair<double, double> Errors(const std::map<uint64_t, Eigen::Vector2d>& before,
                                 const std::map<uint64_t, Eigen::Vector2d>& after,
                                 const Move& move) {
  std::vector<double> errors;
  for (const auto& [id, pixel] : before) {
    if (const auto it = after.find(id); it != after.end()) {
      errors.push_back((it->second - move(pixel)).norm());
    }
  }
  if (errors.empty()) {
    ADD_FAILURE() << "nothing was tracked";
    return {};
  }
  std::sort(errors.begin(), errors.end());
  return {errors[errors.size() / 2], errors.back()};
}

int NumShared(const std::map<uint64_t, Eigen::Vector2d>& a,
              const std::map<uint64_t, Eigen::Vector2d>& b) {
  return static_cast<int>(std::count_if(
      a.begin(), a.end(), [&](const auto& entry) { return b.contains(entry.first); }));
}

TEST(KltTracker, FollowsAShiftToAFractionOfAPixel) {
  const cv::Mat texture = Texture(1);
  KltTracker tracker{KltOptions()};
  const auto before = ById(tracker.Track(ViewOf(Warp(texture, Shift(0.0, 0.0)))));
  EXPECT_EQ(before.size(), 200u);
  const auto after = ById(tracker.Track(ViewOf(Warp(texture, Shift(7.3, -4.6)))));
  EXPECT_GT(NumShared(before, after), 150);
  const auto [median, largest] = Errors(before, after, [](const Eigen::Vector2d& pixel) {
    return Eigen::Vector2d(pixel + Eigen::Vector2d(7.3, -4.6));
  });
  EXPECT_LT(median, 0.08);
  EXPECT_LT(largest, 0.6);
}

TEST(KltTracker, FollowsARotationOverManyImages) {
  const cv::Mat texture = Texture(2);
  KltTracker tracker{KltOptions()};
  constexpr double kTurnRad = 0.01;
  const Eigen::Vector2d center(160.0, 120.0);
  const auto image_at = [&](int step) {
    const double c = std::cos(kTurnRad * step), s = std::sin(kTurnRad * step);
    // About the center, whose coordinates are half a pixel less in OpenCV's convention.
    const double x = center.x() - 0.5, y = center.y() - 0.5;
    return Warp(texture, {c, -s, x - c * (x + 40.0) + s * (y + 40.0), s, c,
                          y - s * (x + 40.0) - c * (y + 40.0)});
  };
  const auto first = ById(tracker.Track(ViewOf(image_at(0))));
  std::map<uint64_t, Eigen::Vector2d> last;
  for (int step = 1; step <= 12; ++step) {
    last = ById(tracker.Track(ViewOf(image_at(step))));
  }
  EXPECT_GT(NumShared(first, last), 100);
  const Eigen::Rotation2D<double> turn(12 * kTurnRad);
  const auto [median, largest] = Errors(first, last, [&](const Eigen::Vector2d& pixel) {
    return Eigen::Vector2d(turn * (pixel - center) + center);
  });
  EXPECT_LT(median, 0.3);
}

TEST(KltTracker, LostFeaturesAreReplacedUnderNewIds) {
  KltTracker tracker{KltOptions()};
  const auto before = ById(tracker.Track(ViewOf(Warp(Texture(3), Shift(0.0, 0.0)))));
  const auto after = ById(tracker.Track(ViewOf(Warp(Texture(4), Shift(0.0, 0.0)))));
  EXPECT_LT(NumShared(before, after), 20);  // Another scene.
  EXPECT_EQ(after.size(), 200u);
  for (const auto& [id, pixel] : after) {
    EXPECT_TRUE(before.contains(id) || id > before.rbegin()->first);
  }
}

TEST(KltTracker, CoveredFeaturesAreGivenUp) {
  const cv::Mat texture = Texture(5);
  KltTracker tracker{KltOptions()};
  const auto before = ById(tracker.Track(ViewOf(Warp(texture, Shift(0.0, 0.0)))));
  cv::Mat covered = Warp(texture, Shift(2.0, 0.0));
  Warp(Texture(6), Shift(0.0, 0.0))(cv::Rect(0, 0, 160, 240))
      .copyTo(covered(cv::Rect(0, 0, 160, 240)));
  const auto after = ById(tracker.Track(ViewOf(covered)));
  int num_left = 0, num_right = 0;
  for (const auto& [id, pixel] : before) {
    if (after.contains(id)) {
      ++(pixel.x() < 150.0 ? num_left : num_right);
    }
  }
  EXPECT_LT(num_left, 10);
  EXPECT_GT(num_right, 60);
}

TEST(KltTracker, DimPartsOfTheImageGetFeaturesToo) {
  cv::Mat image = Warp(Texture(7), Shift(0.0, 0.0));
  cv::Mat right = image(cv::Rect(160, 0, 160, 240));
  right.convertTo(right, -1, 0.2, 100.0);  // A fifth of the contrast.
  KltTracker tracker{KltOptions()};
  const auto features = tracker.Track(ViewOf(image));
  const auto num_right = std::count_if(features.begin(), features.end(), [](const auto& feature) {
    return feature.pixel.x() > 160.0;
  });
  EXPECT_GT(num_right, 80);
  EXPECT_LT(num_right, 120);
}

TEST(KltTracker, FeaturesKeepTheirDistance) {
  KltTracker tracker{KltOptions()};
  const cv::Mat texture = Texture(8);
  tracker.Track(ViewOf(Warp(texture, Shift(0.0, 0.0))));
  const auto features = tracker.Track(ViewOf(Warp(texture, Shift(3.0, 3.0))));
  for (const TrackedFeature& a : features) {
    for (const TrackedFeature& b : features) {
      if (a.track_id < b.track_id) {
        EXPECT_GT((a.pixel - b.pixel).norm(), 8.0);
      }
    }
  }
}

TEST(KltTracker, BlankImagesHaveNoFeatures) {
  KltTracker tracker{KltOptions()};
  const cv::Mat blank(kHeightPx, kWidthPx, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(tracker.Track(ViewOf(blank)).empty());
  EXPECT_EQ(tracker.Track(ViewOf(Warp(Texture(9), Shift(0.0, 0.0)))).size(), 200u);
  EXPECT_TRUE(tracker.Track(ViewOf(blank)).empty());
}

TEST(KltTracker, RowsMayBeFartherApartThanTheyAreLong) {
  const cv::Mat texture = Texture(10);
  const cv::Mat part = texture(cv::Rect(40, 40, kWidthPx, kHeightPx));
  KltTracker strided{KltOptions()};
  KltTracker packed{KltOptions()};
  const auto a = ById(strided.Track(ViewOf(part)));
  const auto b = ById(packed.Track(ViewOf(part.clone())));
  EXPECT_EQ(a, b);
}

TEST(KltTracker, ResetAndAnotherSizeStartAnew) {
  const cv::Mat texture = Texture(11);
  const cv::Mat image = Warp(texture, Shift(0.0, 0.0));
  KltTracker tracker{KltOptions()};
  const auto first = ById(tracker.Track(ViewOf(image)));
  tracker.Reset();
  const auto second = ById(tracker.Track(ViewOf(image)));
  EXPECT_EQ(NumShared(first, second), 0);
  const auto third = ById(tracker.Track(ViewOf(texture)));
  EXPECT_EQ(NumShared(second, third), 0);
}

TEST(KltTracker, RefusesWhatIsNoImage) {
  KltTracker tracker{KltOptions()};
  EXPECT_THROW(tracker.Track({}), Error);
  const std::vector<uint8_t> pixels(100, 0);
  EXPECT_THROW(tracker.Track({pixels.data(), 10, 10, 10}), Error);
  EXPECT_THROW(tracker.Track({pixels.data(), 320, 240, 300}), Error);
}

TEST(KltTracker, RefusesOptionsWithoutSense) {
  KltOptions options;
  options.window_px = 20;
  EXPECT_THROW(KltTracker{options}, Error);
  options = {};
  options.max_features = 0;
  EXPECT_THROW(KltTracker{options}, Error);
}

}  // namespace
}  // namespace cairn::fusion
