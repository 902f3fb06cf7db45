#include "cli/demo/street/guided_matching.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

#include "cli/demo/street/neighbor_pairs.h"

namespace cairn {
namespace {

Camera TestCamera() { return {CameraModel::kPinhole, 640, 480, {420.0, 420.0, 320.0, 240.0}}; }

// Points before two cameras a meter apart, keypoint i of either image being point i. Descriptors
// are random, the second image's a little different.
struct TwoViews {
  Camera camera = TestCamera();
  FeatureSet features[2];
  Rigid3d cams_from_world[2];

  explicit TwoViews(int num_points) {
    cams_from_world[1] =
        Rigid3d(ExpSo3(Eigen::Vector3d(0.02, -0.1, 0.03)), Eigen::Vector3d(-1.0, 0.1, 0.2));
    std::mt19937_64 rng(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<Eigen::Vector3d> points;
    while (static_cast<int>(points.size()) < num_points) {
      const Eigen::Vector3d point(5.0 * uniform(rng), 3.0 * uniform(rng), 8.0 + 3.0 * uniform(rng));
      if (IsSeen(0, point) && IsSeen(1, point)) {
        points.push_back(point);
      }
    }
    std::normal_distribution<float> normal;
    DescriptorMatrix descriptors(num_points, 128);
    for (int i = 0; i < descriptors.size(); ++i) {
      descriptors.data()[i] = std::abs(normal(rng)) * 30.0f;
    }
    for (int view = 0; view < 2; ++view) {
      for (const Eigen::Vector3d& point : points) {
        const Eigen::Vector3d x_in_cam = cams_from_world[view] * point;
        const Eigen::Vector2d pixel = *camera.Project(x_in_cam);
        features[view].keypoints.push_back({static_cast<float>(pixel.x()),
                                            static_cast<float>(pixel.y()),
                                            static_cast<float>(20.0 / x_in_cam.z()), 0.0f});
      }
      features[view].descriptors = descriptors;
    }
    for (int i = 0; i < descriptors.size(); ++i) {
      features[1].descriptors.data()[i] += 3.0f * normal(rng);
    }
  }

  bool IsSeen(int view, const Eigen::Vector3d& point) const {
    const auto pixel = camera.Project(cams_from_world[view] * point);
    return pixel && camera.Contains(*pixel);
  }

  std::vector<FeatureMatch> Match() const {
    return MatchAlongEpipolarLines(MakePosedFeatures(camera, features[0], cams_from_world[0]),
                                   MakePosedFeatures(camera, features[1], cams_from_world[1]));
  }
};

TEST(GuidedMatching, FindsEveryPoint) {
  const TwoViews views(300);
  const std::vector<FeatureMatch> matches = views.Match();
  EXPECT_EQ(matches.size(), 300u);
  for (const FeatureMatch& match : matches) {
    EXPECT_EQ(match.a_idx, match.b_idx);
  }
}

TEST(GuidedMatching, IgnoresTwinsOffTheEpipolarLine) {
  TwoViews views(100);
  // All points look alike: only the geometry can tell them apart, and mostly does.
  for (FeatureSet& features : views.features) {
    features.descriptors.setConstant(10.0f);
  }
  views.features[1].descriptors.setConstant(11.0f);
  int num_right = 0;
  for (const FeatureMatch& match : views.Match()) {
    num_right += match.a_idx == match.b_idx ? 1 : 0;
  }
  EXPECT_GT(num_right, 20);
}

TEST(GuidedMatching, RefusesTwinsOnTheEpipolarLine) {
  TwoViews views(100);
  // A second point on the ray of point 7, twice as far, that looks like it.
  const Eigen::Vector3d ray = *views.camera.Unproject(
      {views.features[0].keypoints[7].x_px, views.features[0].keypoints[7].y_px});
  const auto pixel = views.camera.Project(views.cams_from_world[1] * Eigen::Vector3d(16.0 * ray));
  ASSERT_TRUE(pixel.has_value());
  FeatureSet& second = views.features[1];
  Keypoint twin = second.keypoints[7];
  twin.x_px = static_cast<float>(pixel->x());
  twin.y_px = static_cast<float>(pixel->y());
  second.keypoints.push_back(twin);
  second.descriptors.conservativeResize(101, 128);
  second.descriptors.row(100) = second.descriptors.row(7);
  for (const FeatureMatch& match : views.Match()) {
    EXPECT_NE(match.a_idx, 7);
  }
}

TEST(GuidedMatching, RefusesKeypointsOffTheirLine) {
  TwoViews views(50);
  for (Keypoint& keypoint : views.features[1].keypoints) {
    keypoint.y_px += 12.0f;  // The baseline is nearly horizontal.
  }
  EXPECT_TRUE(views.Match().empty());
}

TEST(GuidedMatching, RefusesPointsBehindTheCameras) {
  TwoViews views(50);
  // Exchanging the images' places makes all rays diverge.
  std::swap(views.features[0], views.features[1]);
  views.cams_from_world[1] =
      Rigid3d(views.cams_from_world[1].rotation.conjugate(), views.cams_from_world[1].translation);
  std::set<int> matched;
  for (const FeatureMatch& match : views.Match()) {
    matched.insert(match.a_idx);
  }
  EXPECT_TRUE(matched.empty());
}

TEST(GuidedMatching, RefusesKeypointsOfOtherSizes) {
  TwoViews views(50);
  for (Keypoint& keypoint : views.features[1].keypoints) {
    keypoint.scale_px *= 3.0f;
  }
  EXPECT_TRUE(views.Match().empty());
}

TEST(GuidedMatching, OfImagesWithoutFeaturesIsEmpty) {
  TwoViews views(1);
  views.features[1] = FeatureSet();
  views.features[1].descriptors.resize(0, 128);
  EXPECT_TRUE(views.Match().empty());
}

PosedFeatures CameraAt(const Camera& camera, const FeatureSet& features, double x_m,
                       double yaw_rad) {
  const Eigen::Quaterniond rotation = ExpSo3(Eigen::Vector3d(0.0, -yaw_rad, 0.0));
  return MakePosedFeatures(camera, features,
                           {rotation, -(rotation * Eigen::Vector3d(x_m, 0.0, 0.0))});
}

TEST(NeighborPairs, AreNearAndLookAtTheSame) {
  const Camera camera = TestCamera();
  const FeatureSet none;
  const std::vector<PosedFeatures> images = {
      CameraAt(camera, none, 0.0, 0.0),   CameraAt(camera, none, 2.0, 0.0),
      CameraAt(camera, none, 4.0, 0.1),   CameraAt(camera, none, 2.0, 3.1),
      CameraAt(camera, none, 300.0, 0.0), CameraAt(camera, none, 2.1, 0.0)};
  const std::vector<std::pair<int, int>> pairs = FindNeighborPairs(images);
  // 3 looks back, 4 is far away, 1 and 5 stand too close together.
  const std::vector<std::pair<int, int>> expected = {{0, 1}, {0, 2}, {0, 5}, {1, 2}, {2, 5}};
  EXPECT_EQ(pairs, expected);
}

TEST(NeighborPairs, AreLimitedToTheBest) {
  const Camera camera = TestCamera();
  const FeatureSet none;
  std::vector<PosedFeatures> images;
  for (int i = 0; i < 10; ++i) {
    images.push_back(CameraAt(camera, none, 1.0 * i, 0.0));
  }
  for (const auto& [a, b] : FindNeighborPairs(images, 1)) {
    EXPECT_EQ(b - a, 1);
  }
}

}  // namespace
}  // namespace cairn
