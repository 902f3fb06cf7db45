#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <utility>

#include "core/features/sift/sift_extractor.h"
#include "lab/descriptors/real_looks.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr int kMaxFeatures = 4000;
constexpr float kMaxMatchRatio = 0.8f;
constexpr double kMaxHomographyErrorPx = 4.0;
constexpr int kMinInliers = 30;
// A point this near to an inlier is assumed to be on the facade's plane.
constexpr double kFacadeRadiusPx = 40.0;

struct Match {
  int a = 0, b = 0;  // Indices of keypoints.
};

Eigen::Vector2d At(const Keypoint& keypoint) { return {keypoint.x_px, keypoint.y_px}; }

// Matches each descriptor to its nearest neighbor if that is clearly nearer than the second.
std::vector<Match> RatioMatches(const DescriptorMatrix& a, const DescriptorMatrix& b) {
  std::vector<Match> matches;
  if (b.rows() == 0) {
    return matches;
  }
  for (int i = 0; i < a.rows(); ++i) {
    Eigen::RowVectorXf similarity = (b * a.row(i).transpose()).transpose();
    int best = 0, second = 0;
    const float best_similarity = similarity.maxCoeff(&best);
    similarity[best] = -1.0f;
    const float second_similarity = similarity.maxCoeff(&second);
    if (1.0f - best_similarity < kMaxMatchRatio * kMaxMatchRatio * (1.0f - second_similarity)) {
      matches.push_back({i, best});
    }
  }
  return matches;
}

struct PlaneTransfer {
  Eigen::Matrix3d b_from_a;
  std::vector<Eigen::Vector2d> inliers_in_a;

  Eigen::Vector2d operator()(const Eigen::Vector2d& pixel) const {
    return (b_from_a * pixel.homogeneous()).hnormalized();
  }
  // d(pixel in b) / d(pixel in a).
  Eigen::Matrix2d Jacobian(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector3d h = b_from_a * pixel.homogeneous();
    return (b_from_a.topLeftCorner<2, 2>() - h.hnormalized() * b_from_a.row(2).head<2>()) / h.z();
  }
  bool Covers(const Eigen::Vector2d& pixel) const {
    return std::any_of(inliers_in_a.begin(), inliers_in_a.end(), [&](const Eigen::Vector2d& p) {
      return (p - pixel).norm() < kFacadeRadiusPx;
    });
  }
};

std::optional<PlaneTransfer> FindPlane(const FeatureSet& a, const FeatureSet& b,
                                       const std::vector<Match>& matches) {
  if (static_cast<int>(matches.size()) < kMinInliers) {
    return std::nullopt;
  }
  std::vector<cv::Point2f> points_a, points_b;
  for (const Match& match : matches) {
    points_a.emplace_back(a.keypoints[match.a].x_px, a.keypoints[match.a].y_px);
    points_b.emplace_back(b.keypoints[match.b].x_px, b.keypoints[match.b].y_px);
  }
  std::vector<unsigned char> is_inlier;
  const cv::Mat homography = cv::findHomography(points_a, points_b, cv::RANSAC,
                                                kMaxHomographyErrorPx, is_inlier, 5000, 0.999);
  if (homography.empty()) {
    return std::nullopt;
  }
  PlaneTransfer plane;
  plane.b_from_a =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(homography.ptr<double>());
  for (size_t i = 0; i < matches.size(); ++i) {
    if (is_inlier[i]) {
      plane.inliers_in_a.emplace_back(points_a[i].x, points_a[i].y);
    }
  }
  return static_cast<int>(plane.inliers_in_a.size()) >= kMinInliers ? std::optional(plane)
                                                                    : std::nullopt;
}

// Returns the keypoint of b that corresponds geometrically to `keypoint` of a, or -1.
int KeypointInB(const FeatureSet& b, const Keypoint& keypoint, const PlaneTransfer& plane,
                const RealLooksOptions& options) {
  const Eigen::Vector2d pixel = At(keypoint);
  const Eigen::Matrix2d jacobian = plane.Jacobian(pixel);
  if (jacobian.determinant() <= 0.0) {
    return -1;
  }
  const Eigen::Vector2d sought = plane(pixel) + options.offset_px;
  const Eigen::Vector2d ahead = jacobian * Eigen::Vector2d(std::cos(keypoint.orientation_rad),
                                                           std::sin(keypoint.orientation_rad));
  const double size = keypoint.scale_px * std::sqrt(jacobian.determinant());
  double least_px = options.max_distance_px;
  int nearest = -1;
  for (int i = 0; i < b.size(); ++i) {
    const double distance_px = (At(b.keypoints[i]) - sought).norm();
    const double turn_rad =
        WrapAngleRad(b.keypoints[i].orientation_rad - std::atan2(ahead.y(), ahead.x()));
    if (distance_px <= least_px && std::abs(turn_rad) <= options.max_orientation_rad &&
        std::abs(std::log2(b.keypoints[i].scale_px / size)) <= options.max_log2_size_ratio) {
      least_px = distance_px;
      nearest = i;
    }
  }
  return nearest;
}

RealLook LookInB(const Keypoint& keypoint, const PlaneTransfer& plane) {
  const Eigen::Matrix2d jacobian = plane.Jacobian(At(keypoint));
  const Eigen::Vector2d stretch = jacobian.jacobiSvd().singularValues();
  RealLook look;
  look.azimuth_rad = static_cast<float>(std::acos(stretch[1] / stretch[0]));
  look.log2_scale = static_cast<float>(0.5 * std::log2(jacobian.determinant()));
  return look;
}

}  // namespace

RealLooks LooksAtFacade(const std::vector<GrayImage>& photos, const RealLooksOptions& options) {
  options.Validate();
  std::vector<FeatureSet> features;
  for (const GrayImage& photo : photos) {
    features.push_back(ExtractSift(photo, {.max_features = kMaxFeatures}));
    NormalizeDescriptors(DescriptorNormalization::kRootSift, &features.back().descriptors);
  }
  RealLooks result;
  std::vector<Eigen::RowVectorXf> rows;
  const auto append = [&](RealLook look, int landmark, int image, int keypoint) {
    look.ornament = look.landmark = landmark;
    look.image = look.appearance_mode = image;
    result.looks.push_back(look);
    rows.emplace_back(features[image].descriptors.row(keypoint));
  };
  int num_landmarks = 0;
  for (int a = 0; a < static_cast<int>(photos.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(photos.size()); ++b) {
      const std::vector<Match> matches =
          RatioMatches(features[a].descriptors, features[b].descriptors);
      const std::optional<PlaneTransfer> plane = FindPlane(features[a], features[b], matches);
      int num_of_pair = 0;
      for (int i = 0; plane && i < features[a].size() && num_of_pair < options.max_landmarks; ++i) {
        const Keypoint& keypoint = features[a].keypoints[i];
        const int j =
            plane->Covers(At(keypoint)) ? KeypointInB(features[b], keypoint, *plane, options) : -1;
        if (j >= 0) {
          append({}, num_landmarks, a, i);
          append(LookInB(keypoint, *plane), num_landmarks++, b, j);
          ++num_of_pair;
        }
      }
    }
  }
  result.root.resize(static_cast<Eigen::Index>(rows.size()), 128);
  for (size_t i = 0; i < rows.size(); ++i) {
    result.root.row(static_cast<Eigen::Index>(i)) = rows[i];
  }
  return result;
}

}  // namespace cairn
