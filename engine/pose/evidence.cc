#include "engine/pose/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/angles.h"
#include "core/features.h"
#include "core/frames.h"
#include "core/keypoint_shape.h"
#include "engine/pose/effective_inliers.h"
#include "engine/pose/evidence_model.h"
#include "engine/pose/landmark_density.h"

namespace cairn {
namespace {

Eigen::Vector2d PixelOf(const QueryContext& query, const Correspondence& match) {
  const Keypoint& keypoint = query.keypoints[match.keypoint_idx];
  return {keypoint.x_px, keypoint.y_px};
}

// Returns the difference of two angles, [0, pi].
double AngleBetweenRad(double a_rad, double b_rad) { return std::abs(WrapAngleRad(a_rad - b_rad)); }

// Returns each inlier's likelihood ratio divided by the number of its keypoint's matches.
std::vector<double> LikelihoodRatios(const QueryContext& query,
                                     const std::vector<Correspondence>& correspondences,
                                     const std::vector<int>& num_matches,
                                     const std::vector<int>& inliers,
                                     const Rigid3d& cam_from_anchor) {
  // Limits a ratio, which adds no certainty beyond, and keeps sums finite.
  constexpr double kMaxLogRatio = 30.0;
  std::vector<LandmarkDensity> densities;
  for (int i = 0; i < query.num_cameras(); ++i) {
    densities.emplace_back(query, correspondences, cam_from_anchor, i);
  }
  std::vector<double> ratios;
  ratios.reserve(inliers.size());
  for (const int index : inliers) {
    const Correspondence& match = correspondences[index];
    const auto traits = TraitsOf(query, match, cam_from_anchor);
    double ratio = 0.0;
    if (traits) {
      const double density =
          match.search_area_sq_px > 0.0f
              ? 1.0 / match.search_area_sq_px
              : densities[query.CameraIdxOf(match.keypoint_idx)].At(PixelOf(query, match));
      const double by_chance = density * num_matches[match.keypoint_idx];
      ratio = std::exp(std::min(
          kMaxLogRatio, LogErrorDensity(*traits) + LogTraitRatio(*traits) - std::log(by_chance)));
    }
    ratios.push_back(ratio);
  }
  return ratios;
}

// Returns the maximum-likelihood share of right keypoints, by expectation maximization. Writes the
// probability that each inlier is right.
double FitShare(const std::vector<double>& ratios, int num_keypoints,
                std::vector<double>* right_probabilities) {
  constexpr int kMaxIterations = 30;
  constexpr double kMaxShare = 0.95;
  double share = 0.1;
  right_probabilities->resize(ratios.size());
  for (int i = 0; i < kMaxIterations; ++i) {
    double num_right = 0.0;
    for (size_t k = 0; k < ratios.size(); ++k) {
      const double right = share * ratios[k];
      (*right_probabilities)[k] = right / (1.0 - share + right);
      num_right += (*right_probabilities)[k];
    }
    const double next = std::min(kMaxShare, std::max(num_right, 1.0) / num_keypoints);
    const bool settled = std::abs(next - share) < 1e-3 * share;
    share = next;
    if (settled) {
      break;
    }
  }
  return share;
}

// Returns the share of the inliers' information that is independent, (0, 1].
double IndependentShare(const QueryContext& query,
                        const std::vector<Correspondence>& correspondences,
                        const std::vector<int>& inliers,
                        const std::vector<double>& right_probabilities) {
  std::vector<std::vector<Eigen::Vector2d>> pixels(query.num_cameras());
  double num_likely = 0.0;
  for (size_t k = 0; k < inliers.size(); ++k) {
    if (right_probabilities[k] >= 0.5) {
      const Correspondence& match = correspondences[inliers[k]];
      pixels[query.CameraIdxOf(match.keypoint_idx)].push_back(PixelOf(query, match));
      num_likely += 1.0;
    }
  }
  if (num_likely == 0.0) {
    return 1.0;
  }
  double num_independent = 0.0;
  for (int i = 0; i < query.num_cameras(); ++i) {
    const Camera& camera = query.CameraAt(i);
    num_independent += EffectiveInliers(pixels[i], camera.width_px(), camera.height_px());
  }
  return num_independent / num_likely;
}

}  // namespace

double LogErrorDensity(const InlierTraits& traits) {
  const EvidenceModel& model = kEvidenceModel;
  const double from_scale_px = model.error_per_scale * traits.keypoint_scale_px;
  const double from_landmark_px = model.landmark_share * traits.landmark_sigma_px;
  const double sq_scale_px = model.error_px * model.error_px + from_scale_px * from_scale_px +
                             from_landmark_px * from_landmark_px;
  const double freedom = model.error_degrees_of_freedom;
  return -std::log(2.0 * kPi * sq_scale_px) -
         0.5 * (freedom + 2.0) *
             std::log1p(traits.error_px * traits.error_px / (freedom * sq_scale_px));
}

double LogTraitRatio(const InlierTraits& traits) {
  const EvidenceModel& model = kEvidenceModel;
  const double of_orientation =
      traits.orientation_rad < 0.0
          ? 0.0
          : model.orientation_offset + model.orientation.LogRatio(traits.orientation_rad);
  const double of_size =
      std::isnan(traits.log_size) ? -model.size_offset : model.size.LogRatio(traits.log_size);
  return model.offset - model.distance_weight * traits.sq_distance + of_size + of_orientation +
         model.azimuth.LogRatio(traits.azimuth_rad);
}

std::optional<InlierTraits> TraitsOf(const QueryContext& query, const Correspondence& match,
                                     const Rigid3d& cam_from_anchor) {
  const Keypoint& keypoint = query.keypoints[match.keypoint_idx];
  const int camera_idx = query.CameraIdxOf(match.keypoint_idx);
  const Camera& camera = query.CameraAt(camera_idx);
  const Rigid3d own_from_anchor = query.OwnFromFirst(camera_idx) * cam_from_anchor;
  const Eigen::Vector3d x_in_own = own_from_anchor * match.x_in_anchor;
  const auto pixel = camera.Project(x_in_own);
  if (!pixel) {
    return std::nullopt;
  }
  const double px_per_m = camera.focal_px() / x_in_own.norm();
  InlierTraits traits;
  traits.error_px = (*pixel - PixelOf(query, match)).norm();
  traits.keypoint_scale_px = keypoint.scale_px;
  traits.landmark_sigma_px = px_per_m * match.sigma_m;
  if (query.same_landmark_distance > 0.0) {
    traits.sq_distance = match.descriptor_sq_distance /
                         (query.same_landmark_distance * query.same_landmark_distance);
  }
  traits.log_size = match.size_m > 0.0f && HasScale(keypoint)
                        ? std::log(keypoint.scale_px / (px_per_m * match.size_m))
                        : std::numeric_limits<double>::quiet_NaN();
  traits.orientation_rad = -1.0;
  if (match.orientation_rad) {
    const auto angle_rad =
        GravityRectifiedOrientationRad(camera, keypoint, own_from_anchor.rotation * DownInEnu());
    if (angle_rad) {
      traits.orientation_rad = AngleBetweenRad(*angle_rad, *match.orientation_rad);
    }
  }
  const Eigen::Vector3d to_camera = own_from_anchor.Inverse().translation - match.x_in_anchor;
  traits.azimuth_rad = AngleBetweenRad(std::atan2(to_camera.y(), to_camera.x()), match.azimuth_rad);
  return traits;
}

PoseEvidence WeighEvidence(const QueryContext& query,
                           const std::vector<Correspondence>& correspondences,
                           const std::vector<int>& inliers, const Rigid3d& cam_from_anchor) {
  PoseEvidence evidence;
  if (inliers.empty()) {
    return evidence;
  }
  std::vector<int> num_matches(query.keypoints.size(), 0);
  for (const Correspondence& match : correspondences) {
    ++num_matches[match.keypoint_idx];
  }
  const auto num_keypoints = static_cast<int>(
      std::count_if(num_matches.begin(), num_matches.end(), [](int count) { return count > 0; }));
  const std::vector<double> ratios =
      LikelihoodRatios(query, correspondences, num_matches, inliers, cam_from_anchor);
  const double share = FitShare(ratios, num_keypoints, &evidence.right_probabilities);
  const auto num_others = static_cast<double>(num_keypoints) - static_cast<double>(inliers.size());
  double log_ratio = num_others * std::log1p(-share);
  for (const double ratio : ratios) {
    log_ratio += std::log1p(share * (ratio - 1.0));
  }
  evidence.log_ratio =
      log_ratio * IndependentShare(query, correspondences, inliers, evidence.right_probabilities);
  return evidence;
}

}  // namespace cairn
