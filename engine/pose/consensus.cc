#include "engine/pose/consensus.h"

#include <algorithm>

#include "engine/pose/score_block.h"

namespace cairn {
namespace {

// Share of the good poses that may be rejected early. Drawing another pose costs less than scoring
// 100 correspondences, so losing a few good poses is cheaper than certainty. 0.05 takes 0.92 of the
// time of 0.005 at 5 % inliers; a larger share saves no more time (cairn_pose_bench).
constexpr double kMaxRejectedShare = 0.05;

// Returns a pose about the origin of the set.
FloatModel MakeModel(const Eigen::Matrix<double, 3, 4>& cam_from_anchor,
                     const Eigen::Vector3d& origin_in_anchor, double extra_sq_rad) {
  const Eigen::Vector3d translation =
      cam_from_anchor.leftCols<3>() * origin_in_anchor + cam_from_anchor.col(3);
  FloatModel model;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      model.r[3 * row + column] = static_cast<float>(cam_from_anchor(row, column));
    }
    model.t[row] = static_cast<float>(translation[row]);
  }
  model.extra_sq_rad = static_cast<float>(extra_sq_rad);
  return model;
}

}  // namespace

ConsensusSet::ConsensusSet(const std::vector<RayObservation>& observations,
                           const ConsensusOptions& options)
    : options_(options), size_(static_cast<int>(observations.size())), test_(kMaxRejectedShare) {
  const size_t padded = (observations.size() + kScoreBlock - 1) / kScoreBlock * kScoreBlock;
  for (std::vector<float>* array : {&ray_x_, &ray_y_, &ray_z_, &point_x_, &point_y_, &point_z_,
                                    &sq_threshold_, &sq_sigma_, &gains_}) {
    // A zero ray has depth 0 from every pose, so padding is never an inlier.
    array->assign(padded, 0.0f);
  }
  for (const RayObservation& observation : observations) {
    origin_in_anchor_ += observation.x_in_anchor / static_cast<double>(size_);
  }
  const bool has_origins = std::any_of(
      observations.begin(), observations.end(),
      [](const RayObservation& observation) { return !observation.origin_in_cam.isZero(); });
  if (has_origins) {
    for (std::vector<float>* array : {&origin_x_, &origin_y_, &origin_z_}) {
      array->assign(padded, 0.0f);
    }
  }
  for (int i = 0; i < size_; ++i) {
    const RayObservation& observation = observations[i];
    if (has_origins) {
      const Eigen::Vector3f origin = observation.origin_in_cam.cast<float>();
      origin_x_[i] = origin.x(), origin_y_[i] = origin.y(), origin_z_[i] = origin.z();
    }
    const Eigen::Vector3f ray = observation.ray_in_cam.cast<float>();
    const Eigen::Vector3f point = (observation.x_in_anchor - origin_in_anchor_).cast<float>();
    ray_x_[i] = ray.x(), ray_y_[i] = ray.y(), ray_z_[i] = ray.z();
    point_x_[i] = point.x(), point_y_[i] = point.y(), point_z_[i] = point.z();
    sq_threshold_[i] = static_cast<float>(observation.threshold_rad * observation.threshold_rad);
    sq_sigma_[i] = static_cast<float>(observation.sigma_m * observation.sigma_m);
    if (i == 0 || observation.keypoint_idx != observations[i - 1].keypoint_idx) {
      keypoint_begin_.push_back(i);
    }
  }
  keypoint_begin_.push_back(size_);
  best_observations_.resize(keypoint_begin_.size() - 1);
}

bool ConsensusSet::FillGains(const Eigen::Matrix<double, 3, 4>& cam_from_anchor,
                             double extra_sq_rad, double gain_to_beat) {
  const FloatModel model = MakeModel(cam_from_anchor, origin_in_anchor_, extra_sq_rad);
  const auto score_block =
      options_.kernel == ConsensusKernel::kPlain ? ScoreBlockPlain : ScoreBlockVectorized;
  const bool may_reject = options_.early_rejection && gain_to_beat > 0.0;
  if (may_reject) {
    test_.SetGoodGain(gain_to_beat / size_);
  }
  double optimistic_gain = 0.0;  // Counts every observation of a keypoint.
  for (int begin = 0; begin < size_; begin += kScoreBlock) {
    const bool has_origins = !origin_x_.empty();
    const ScoreBlockInput block = {&ray_x_[begin],
                                   &ray_y_[begin],
                                   &ray_z_[begin],
                                   has_origins ? &origin_x_[begin] : nullptr,
                                   has_origins ? &origin_y_[begin] : nullptr,
                                   has_origins ? &origin_z_[begin] : nullptr,
                                   &point_x_[begin],
                                   &point_y_[begin],
                                   &point_z_[begin],
                                   &sq_threshold_[begin],
                                   &sq_sigma_[begin]};
    const float gain = score_block(block, model, &gains_[begin]);
    if (!may_reject) {
      continue;
    }
    const int num_tested = std::min(size_, begin + kScoreBlock);
    optimistic_gain += gain;
    const bool beaten = optimistic_gain + (size_ - num_tested) <= gain_to_beat;
    if (beaten || test_.Rejects(num_tested, optimistic_gain)) {
      test_.LearnBadGain(optimistic_gain / num_tested);
      return false;
    }
  }
  return true;
}

double ConsensusSet::Gain(const Eigen::Matrix<double, 3, 4>& cam_from_anchor, double extra_sq_rad,
                          double gain_to_beat) {
  if (!FillGains(cam_from_anchor, extra_sq_rad, gain_to_beat)) {
    return 0.0;
  }
  double sum = 0.0;
  for (int k = 0; k < num_keypoints(); ++k) {
    float best = gains_[keypoint_begin_[k]];
    for (int i = keypoint_begin_[k] + 1; i < keypoint_begin_[k + 1]; ++i) {
      best = std::max(best, gains_[i]);
    }
    sum += best;
  }
  return sum;
}

const std::vector<int>& ConsensusSet::BestObservations(
    const Eigen::Matrix<double, 3, 4>& cam_from_anchor, double extra_sq_rad) {
  FillGains(cam_from_anchor, extra_sq_rad, -1.0);
  for (int k = 0; k < num_keypoints(); ++k) {
    int best = -1;
    float best_gain = 0.0f;
    for (int i = keypoint_begin_[k]; i < keypoint_begin_[k + 1]; ++i) {
      if (gains_[i] > best_gain) {
        best = i;
        best_gain = gains_[i];
      }
    }
    best_observations_[k] = best;
  }
  return best_observations_;
}

}  // namespace cairn
