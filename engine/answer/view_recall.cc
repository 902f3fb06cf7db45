#include "engine/answer/view_recall.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "core/rotation_between.h"
#include "engine/refinement/near_keyframes.h"

namespace cairn {
namespace {

// Returns how well a landmark is expected to match that is seen along `from_query` and was mapped
// along `from_keyframe`, both in one frame: 1 from the same place, falling with the change of scale
// and direction as matches of SIFT do.
double ExpectedMatch(const Eigen::Vector3d& from_query, const Eigen::Vector3d& from_keyframe) {
  constexpr double kLogScale = 0.4;   // A factor of 1.5.
  constexpr double kAngleRad = 0.44;  // 25 degrees.
  const double log_ratio = std::log(from_query.norm() / from_keyframe.norm()) / kLogScale;
  const double angle = AngleBetweenRad(from_query, from_keyframe) / kAngleRad;
  return std::exp(-0.5 * (log_ratio * log_ratio + angle * angle));
}

// The probability that the match of each landmark among the inliers is right.
std::unordered_map<uint64_t, double> RightByLandmark(const std::vector<TileView>& tiles,
                                                     const PoseHypothesis& hypothesis) {
  std::unordered_map<uint64_t, double> right;
  const PoseEstimate& estimate = hypothesis.estimate;
  for (size_t i = 0; i < estimate.inliers.size(); ++i) {
    const Correspondence& match = (*hypothesis.correspondences)[estimate.inliers[i]];
    double& probability =
        right[Value(tiles[match.tile_idx].tile->landmarks().landmark_ids[match.landmark_idx])];
    probability = std::max(probability, estimate.right_probabilities[i]);
  }
  return right;
}

// Tells whether a point is in view of any camera of the query.
class View {
 public:
  View(const QueryContext& query, const Camera& camera, const Rigid3d& cam_from_anchor) {
    for (int i = 0; i < query.num_cameras(); ++i) {
      cameras_.push_back(
          {i == 0 ? camera : query.CameraAt(i), query.OwnFromFirst(i) * cam_from_anchor});
    }
  }
  bool Contains(const Eigen::Vector3d& x_in_anchor) const {
    return std::any_of(cameras_.begin(), cameras_.end(), [&](const Posed& posed) {
      const auto pixel = posed.camera.Project(posed.own_from_anchor * x_in_anchor);
      return pixel && posed.camera.Contains(*pixel);
    });
  }

 private:
  struct Posed {
    Camera camera;
    Rigid3d own_from_anchor;
  };
  std::vector<Posed> cameras_;
};

}  // namespace

double RecallConfidence(double view_recall) {
  constexpr double kHalfRecall = 0.028, kSlope = 6.0;
  return 1.0 / (1.0 + std::pow(kHalfRecall / view_recall, kSlope));
}

double ViewRecall(const QueryContext& query, const std::vector<TileView>& tiles,
                  const Camera& camera, const PoseHypothesis& hypothesis) {
  constexpr int kMaxKeyframes = 5;
  const Rigid3d& cam_from_anchor = hypothesis.estimate.cam_from_anchor;
  const Rigid3d anchor_from_cam = cam_from_anchor.Inverse();
  const View view(query, camera, cam_from_anchor);
  const std::unordered_map<uint64_t, double> right = RightByLandmark(tiles, hypothesis);
  const auto num_keypoints = static_cast<double>(query.num_keypoints());
  double num_expected = 0.0, num_found = 0.0;  // Sums over the keyframes.
  for (const KeyframeRef& near : NearKeyframes(tiles, anchor_from_cam, kMaxKeyframes)) {
    const TileView& tile_view = tiles[near.tile_idx];
    const TileCovisibility& covisibility = tile_view.tile->covisibility();
    const TileLandmarks& landmarks = tile_view.tile->landmarks();
    const Eigen::Vector3d keyframe_center =
        (tile_view.anchor_from_tile *
         covisibility.keyframes[near.keyframe_idx].cam_from_tile.Inverse())
            .translation;
    double in_view = 0.0;
    for (const uint32_t landmark_idx : covisibility.LandmarksOfKeyframe(near.keyframe_idx)) {
      const Eigen::Vector3d x_in_anchor =
          tile_view.anchor_from_tile * landmarks.x_in_tile[landmark_idx].cast<double>();
      if (view.Contains(x_in_anchor)) {
        in_view +=
            ExpectedMatch(x_in_anchor - anchor_from_cam.translation, x_in_anchor - keyframe_center);
        const auto found = right.find(Value(landmarks.landmark_ids[landmark_idx]));
        num_found += found == right.end() ? 0.0 : found->second;
      }
    }
    // A smooth minimum of the landmarks in view and the keypoints that may show them.
    num_expected += in_view * num_keypoints / std::max(1.0, in_view + num_keypoints);
  }
  return std::min(1.0, (num_found + 1.0) / (num_expected + 1.0));
}

}  // namespace cairn
