#include "cli/demo/street/guided_matching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/angles.h"
#include "core/keypoint_shape.h"

namespace cairn {
namespace {

// Sine of the smallest angle to the baseline at which a ray can be triangulated.
constexpr double kMinSinToBaseline = 0.05;
// Two keypoints this close are one point, for example found with two orientations.
constexpr double kSamePointPx = 3.0;
constexpr double kMaxEpipolarErrorPx = 2.0;  // In both images.
// Largest ratio of the best to the second-best distance. The second best is taken from the same
// epipolar line, where the repetitions of a facade are, and is another point than the best.
constexpr double kMaxRatio = 0.8;
// Largest descriptor distance, relative to the descriptors' length. If a line has few candidates, a
// match could pass the ratio test without being similar.
constexpr double kMaxRelativeDistance = 0.5;
constexpr double kMinDepthM = 0.5;  // Distance from either camera.
constexpr double kMaxDepthM = 150.0;
constexpr double kMaxSizeRatio = 2.0;  // Ratio of the physical sizes of the two keypoints.

// A keypoint in polar coordinates about the baseline.
struct PolarRay {
  double plane_rad = 0.0;  // Angle of the epipolar plane, in (-pi, pi].
  // Cosine of the angle between the ray and the baseline (from a to b for both images).
  double cos = 0.0;
  double sin = 0.0;
  int idx = 0;
};

// Returns the rays that can be triangulated, ordered by plane angle.
std::vector<PolarRay> PolarRays(const PosedFeatures& image, const Eigen::Matrix3d& axes) {
  std::vector<PolarRay> rays;
  rays.reserve(image.rays_in_world.size());
  for (size_t i = 0; i < image.rays_in_world.size(); ++i) {
    const Eigen::Vector3d ray = axes * image.rays_in_world[i];
    const double sin = std::hypot(ray.x(), ray.y());
    if (sin >= kMinSinToBaseline) {
      rays.push_back({std::atan2(ray.y(), ray.x()), ray.z(), sin, static_cast<int>(i)});
    }
  }
  std::sort(rays.begin(), rays.end(), [](const PolarRay& p, const PolarRay& q) {
    return std::pair(p.plane_rad, p.idx) < std::pair(q.plane_rad, q.idx);
  });
  return rays;
}

// Repeats the rays near -pi and pi at the other end, so that a search window never wraps around.
void UnrollEnds(double window_rad, std::vector<PolarRay>* rays) {
  const size_t num_rays = rays->size();
  std::vector<PolarRay> before, after;
  for (size_t i = 0; i < num_rays; ++i) {
    PolarRay ray = (*rays)[i];
    if (ray.plane_rad > kPi - window_rad) {
      ray.plane_rad -= 2.0 * kPi;
      before.push_back(ray);
    } else if (ray.plane_rad < window_rad - kPi) {
      ray.plane_rad += 2.0 * kPi;
      after.push_back(ray);
    }
  }
  rays->insert(rays->begin(), before.begin(), before.end());
  rays->insert(rays->end(), after.begin(), after.end());
}

struct Candidate {
  int b_idx;
  float sq_distance;
};

// Geometry of one image pair.
class PairGeometry {
 public:
  PairGeometry(const PosedFeatures& a, const PosedFeatures& b) : a_(a), b_(b) {
    const Eigen::Vector3d baseline = b.center_in_world - a.center_in_world;
    baseline_m_ = baseline.norm();
    axes_.row(2) = baseline.transpose() / baseline_m_;
    axes_.row(0) = axes_.row(2).unitOrthogonal();
    axes_.row(1) = axes_.row(2).cross(axes_.row(0));
    max_error_rad_ = kMaxEpipolarErrorPx / std::max(a.camera->focal_px(), b.camera->focal_px());
  }

  double max_error_rad() const { return max_error_rad_; }
  std::vector<PolarRay> RaysOf(const PosedFeatures& image) const { return PolarRays(image, axes_); }

  // Returns true if the two keypoints may show one point: their rays meet in front of both cameras
  // within the depth range, and the keypoints have about the same size there.
  bool Agree(const PolarRay& ray_a, const PolarRay& ray_b) const {
    if (std::abs(ray_a.plane_rad - ray_b.plane_rad) * ray_b.sin > max_error_rad_) {
      return false;
    }
    // Law of sines in the triangle of the two centers and the point.
    const double sin_parallax = ray_b.sin * ray_a.cos - ray_b.cos * ray_a.sin;
    const double depth_a = baseline_m_ * ray_b.sin / sin_parallax;
    const double depth_b = baseline_m_ * ray_a.sin / sin_parallax;
    if (!(sin_parallax > 0.0) || std::min(depth_a, depth_b) < kMinDepthM ||
        std::max(depth_a, depth_b) > kMaxDepthM) {
      return false;
    }
    const Keypoint& keypoint_a = a_.features->keypoints[ray_a.idx];
    const Keypoint& keypoint_b = b_.features->keypoints[ray_b.idx];
    if (!HasScale(keypoint_a) || !HasScale(keypoint_b)) {
      return true;
    }
    const double size_a = keypoint_a.scale_px * depth_a / a_.camera->focal_px();
    const double size_b = keypoint_b.scale_px * depth_b / b_.camera->focal_px();
    return size_a <= kMaxSizeRatio * size_b && size_b <= kMaxSizeRatio * size_a;
  }

 private:
  const PosedFeatures& a_;
  const PosedFeatures& b_;
  double baseline_m_ = 0.0;
  double max_error_rad_ = 0.0;
  Eigen::Matrix3d axes_;  // Rows: two axes across the baseline, then the baseline from a to b.
};

// Returns the best candidate if it beats all candidates that are a different point; otherwise -1.
int BestByRatio(const std::vector<Candidate>& candidates, const FeatureSet& features_b) {
  int best = -1;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (best < 0 || candidates[i].sq_distance < candidates[best].sq_distance) {
      best = static_cast<int>(i);
    }
  }
  if (best < 0) {
    return -1;
  }
  const Keypoint& winner = features_b.keypoints[candidates[best].b_idx];
  for (const Candidate& other : candidates) {
    const Keypoint& keypoint = features_b.keypoints[other.b_idx];
    const bool same_point =
        std::hypot(keypoint.x_px - winner.x_px, keypoint.y_px - winner.y_px) < kSamePointPx;
    if (!same_point && candidates[best].sq_distance > kMaxRatio * kMaxRatio * other.sq_distance) {
      return -1;
    }
  }
  return best;
}

}  // namespace

std::vector<FeatureMatch> MatchAlongEpipolarLines(const PosedFeatures& a, const PosedFeatures& b) {
  const PairGeometry geometry(a, b);
  const std::vector<PolarRay> rays_a = geometry.RaysOf(a);
  std::vector<PolarRay> rays_b = geometry.RaysOf(b);
  UnrollEnds(geometry.max_error_rad() / kMinSinToBaseline, &rays_b);

  std::vector<float> best_sq_distance_of_b(b.features->size(),
                                           std::numeric_limits<float>::infinity());
  std::vector<FeatureMatch> matches;
  std::vector<Candidate> candidates;
  for (const PolarRay& ray_a : rays_a) {
    const double window_rad = geometry.max_error_rad() / ray_a.sin;
    candidates.clear();
    const auto first = std::lower_bound(
        rays_b.begin(), rays_b.end(), ray_a.plane_rad - window_rad,
        [](const PolarRay& ray, double plane_rad) { return ray.plane_rad < plane_rad; });
    for (auto ray_b = first;
         ray_b != rays_b.end() && ray_b->plane_rad <= ray_a.plane_rad + window_rad; ++ray_b) {
      if (geometry.Agree(ray_a, *ray_b)) {
        const float sq_distance =
            (a.features->descriptors.row(ray_a.idx) - b.features->descriptors.row(ray_b->idx))
                .squaredNorm();
        candidates.push_back({ray_b->idx, sq_distance});
        best_sq_distance_of_b[ray_b->idx] =
            std::min(best_sq_distance_of_b[ray_b->idx], sq_distance);
      }
    }
    const double max_distance =
        kMaxRelativeDistance * a.features->descriptors.row(ray_a.idx).norm();
    const int best = BestByRatio(candidates, *b.features);
    if (best >= 0 && candidates[best].sq_distance <= max_distance * max_distance) {
      matches.push_back(
          {ray_a.idx, candidates[best].b_idx, std::sqrt(candidates[best].sq_distance)});
    }
  }
  std::erase_if(matches, [&](const FeatureMatch& match) {
    return match.distance > std::sqrt(best_sq_distance_of_b[match.b_idx]);
  });
  std::sort(matches.begin(), matches.end(),
            [](const FeatureMatch& p, const FeatureMatch& q) { return p.a_idx < q.a_idx; });
  return matches;
}

}  // namespace cairn
