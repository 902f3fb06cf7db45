#include "engine/voting/candidate_support.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/features.h"
#include "core/simd.h"

namespace cairn {
namespace {

// A candidate with the tolerances of the test.
struct SupportTest {
  double x, y, z;  // Camera center, relative to RayArrays::center_in_anchor.
  double cos_yaw, sin_yaw;
  double min_cosine;     // Cosine of the largest azimuth difference.
  double tolerance_rad;  // Tolerance of directions.
  double slack_m;        // Tolerance of distances.
};

// Returns 1 - (e / t)^2 of ray i, or 0 if the ray does not agree.
template <bool kIn3d, bool kHasOrigins>
[[gnu::always_inline]] inline double RayGain(const RayPointers<double>& rays,
                                             const SupportTest& test, int i) {
  const double cos_yaw = test.cos_yaw, sin_yaw = test.sin_yaw;
  double dx = cos_yaw * rays.direction_x[i] - sin_yaw * rays.direction_y[i];
  double dy = sin_yaw * rays.direction_x[i] + cos_yaw * rays.direction_y[i];
  double dz = rays.direction_z[i];
  double x = rays.x[i] - test.x, y = rays.y[i] - test.y, z = rays.z[i] - test.z;
  if constexpr (kHasOrigins) {
    x -= cos_yaw * rays.origin_x[i] - sin_yaw * rays.origin_y[i];
    y -= sin_yaw * rays.origin_x[i] + cos_yaw * rays.origin_y[i];
    z -= rays.origin_z[i];
  }
  const double cosine = -(dx * rays.view_x[i] + dy * rays.view_y[i]);
  const bool azimuth_fits = cosine >= test.min_cosine * rays.horizontal[i];
  double distance_scale = 1.0;
  if constexpr (kIn3d) {
    distance_scale = 1.0 / std::max(1e-9, rays.horizontal[i]);
    dx *= distance_scale, dy *= distance_scale, dz = 0.0, z = 0.0;
  }
  const double cross_x = dy * z - dz * y, cross_y = dz * x - dx * z, cross_z = dx * y - dy * x;
  const double sq_offset = cross_x * cross_x + cross_y * cross_y + cross_z * cross_z;
  const double distance_m = distance_scale * std::sqrt(x * x + y * y + z * z);
  const double tolerance_m = test.tolerance_rad * distance_m + test.slack_m;
  const double gain = 1.0 - sq_offset / (tolerance_m * tolerance_m);
  const bool agrees = azimuth_fits & (dx * x + dy * y + dz * z > 0.0) &
                      (distance_m >= rays.min_distance_m[i] - test.slack_m) &
                      (distance_m <= rays.max_distance_m[i] + test.slack_m) & (gain > 0.0);
  return agrees ? gain : 0.0;
}

template <bool kIn3d, bool kHasOrigins>
[[gnu::always_inline]] inline void AllGains(const RayPointers<double>& rays,
                                            const SupportTest& test, int size,
                                            double* __restrict gains) {
  for (int i = 0; i < size; ++i) {
    gains[i] = RayGain<kIn3d, kHasOrigins>(rays, test, i);
  }
}

CAIRN_VECTOR_CLONES
void RayGains(const RayPointers<double>& pointers, const SupportTest& test, bool in_3d,
              bool has_origins, int size, double* __restrict gains) {
  const RayPointers<double> rays = pointers;
  if (in_3d) {
    has_origins ? AllGains<true, true>(rays, test, size, gains)
                : AllGains<true, false>(rays, test, size, gains);
  } else {
    has_origins ? AllGains<false, true>(rays, test, size, gains)
                : AllGains<false, false>(rays, test, size, gains);
  }
}

// The center is relative to RayArrays::center_in_anchor.
struct SupportPose {
  Eigen::Vector3d center;
  double yaw_rad;
};

struct SupportTolerance {
  double direction_rad;
  double slack_m;
};

SupportTolerance WidestTolerance(const VotingOptions& options) {
  return {options.direction_tolerance_rad, options.cell_xy_m};
}

// Returns the gain of each ray, including padding.
std::vector<double> GainsAt(const RayArrays<double>& rays, const SupportPose& pose,
                            const SupportTolerance& tolerance, const VotingOptions& options,
                            bool in_3d) {
  const SupportTest test = {pose.center.x(),         pose.center.y(),
                            pose.center.z(),         std::cos(pose.yaw_rad),
                            std::sin(pose.yaw_rad),  std::cos(options.max_azimuth_difference_rad),
                            tolerance.direction_rad, tolerance.slack_m};
  std::vector<double> gains(rays.padded_size());
  RayGains(RayPointers<double>(rays), test, in_3d, rays.has_origins(), rays.padded_size(),
           gains.data());
  return gains;
}

// Sums the best gain of each keypoint.
double SumOverKeypoints(const RayArrays<double>& rays, const std::vector<double>& gains) {
  double sum = 0.0, best_gain = 0.0;  // best_gain is that of the current keypoint.
  for (int i = 0; i < rays.num_rays; ++i) {
    if (i > 0 && rays.voters[i - 1] != rays.voters[i]) {
      sum += best_gain;
      best_gain = 0.0;
    }
    best_gain = std::max(best_gain, gains[i]);
  }
  return sum + best_gain;
}

std::vector<int> AgreeingCorrespondences(const RayArrays<double>& rays,
                                         const std::vector<double>& gains) {
  std::vector<int> correspondences;
  for (int i = 0; i < rays.num_rays; ++i) {
    if (gains[i] > 0.0) {
      correspondences.push_back(rays.correspondence_idxs[i]);
    }
  }
  std::sort(correspondences.begin(), correspondences.end());
  return correspondences;
}

// One Gauss-Newton step on the offsets of the landmarks from the rays that agree, weighted by their
// gains. The pose is held to within a cell and a yaw step. Let P be the projection perpendicular to
// a ray of direction d, v the vector to the landmark, l = d.v, and o the ray's origin. The offset
// is e = P v. Its derivatives are -P with respect to the center, and c = -l z x d - P (z x o) with
// respect to the yaw. As P e = e and P c = c, they enter the normal equations unprojected.
SupportPose Settle(const RayArrays<double>& rays, const std::vector<double>& gains,
                   const SupportPose& pose, const SupportTolerance& tolerance,
                   const VotingOptions& options) {
  const Eigen::Vector4d sigmas(options.cell_xy_m, options.cell_xy_m, options.cell_z_m,
                               options.yaw_step_rad);
  Eigen::Matrix4d information = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const auto z_cross = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(-x.y(), x.x(), 0.0); };
  for (int i = 0; i < rays.num_rays; ++i) {
    if (gains[i] <= 0.0) {
      continue;
    }
    const Eigen::Vector3d d =
        turn * Eigen::Vector3d(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
    Eigen::Vector3d v = Eigen::Vector3d(rays.x[i], rays.y[i], rays.z[i]) - pose.center;
    Eigen::Vector3d turned = Eigen::Vector3d::Zero();  // z x o.
    if (rays.has_origins()) {
      const Eigen::Vector3d origin =
          turn * Eigen::Vector3d(rays.origin_x[i], rays.origin_y[i], rays.origin_z[i]);
      v -= origin;
      turned = z_cross(origin);
    }
    const double l = d.dot(v);
    const Eigen::Vector3d e = v - l * d;
    const Eigen::Vector3d c = -l * z_cross(d) - (turned - d.dot(turned) * d);
    const double sigma_m = tolerance.direction_rad * l + tolerance.slack_m;
    const double weight = gains[i] / (sigma_m * sigma_m);
    information.topLeftCorner<3, 3>() -= weight * d * d.transpose();
    information.diagonal().head<3>().array() += weight;
    information.topRightCorner<3, 1>() -= weight * c;
    information(3, 3) += weight * c.squaredNorm();
    gradient.head<3>() -= weight * e;
    gradient[3] += weight * c.dot(e);
  }
  information.bottomLeftCorner<1, 3>() = information.topRightCorner<3, 1>().transpose();
  const Eigen::Vector4d step = -information.llt().solve(gradient);
  return {pose.center + step.head<3>(), WrapAngleRad(pose.yaw_rad + step[3])};
}

}  // namespace

PoseCandidate SupportedCandidate(const RayArrays<double>& rays,
                                 const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                                 const VotingOptions& options) {
  const std::vector<double> gains =
      GainsAt(rays, {center_in_anchor - rays.center_in_anchor, yaw_rad}, WidestTolerance(options),
              options, options.filter == OutlierFilter::kVoting3d);
  return {center_in_anchor, yaw_rad, SumOverKeypoints(rays, gains),
          AgreeingCorrespondences(rays, gains)};
}

PoseCandidate SettledCandidate(const RayArrays<double>& rays,
                               const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                               const VotingOptions& options) {
  constexpr int kNumSteps = 2;
  constexpr double kNarrowing = 0.7;  // Factor of the tolerances in each step.
  SupportPose pose = {center_in_anchor - rays.center_in_anchor, yaw_rad};
  SupportTolerance tolerance = WidestTolerance(options);
  std::vector<double> gains = GainsAt(rays, pose, tolerance, options, /*in_3d=*/false);
  for (int step = 0; step < kNumSteps; ++step) {
    pose = Settle(rays, gains, pose, tolerance, options);
    tolerance = {kNarrowing * tolerance.direction_rad, kNarrowing * tolerance.slack_m};
    gains = GainsAt(rays, pose, tolerance, options, /*in_3d=*/false);
  }
  const double score = SumOverKeypoints(rays, gains);
  gains = GainsAt(rays, pose, WidestTolerance(options), options, /*in_3d=*/false);
  return {pose.center + rays.center_in_anchor, pose.yaw_rad, score,
          AgreeingCorrespondences(rays, gains)};
}

}  // namespace cairn
