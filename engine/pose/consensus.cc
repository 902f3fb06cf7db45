#include "engine/pose/consensus.h"

#include <algorithm>
#include <cmath>

#include "engine/vector_clones.h"

namespace cairn {
namespace {

constexpr int kBlock = 64;  // Observations scored between two looks at the test.
constexpr int kNumLanes = 16;

// A pose [R | t] about the origin of the set, and the addition to squared thresholds.
struct FloatModel {
  float r[9];  // Row-major.
  float t[3];
  float extra_sq_rad;

  FloatModel(const Eigen::Matrix<double, 3, 4>& cam_from_anchor,
             const Eigen::Vector3d& origin_in_anchor, double extra_sq)
      : extra_sq_rad(static_cast<float>(extra_sq)) {
    const Eigen::Vector3d translation =
        cam_from_anchor.leftCols<3>() * origin_in_anchor + cam_from_anchor.col(3);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        r[3 * row + column] = static_cast<float>(cam_from_anchor(row, column));
      }
      t[row] = static_cast<float>(translation[row]);
    }
  }
};

// The arrays of one block.
struct BlockView {
  const float *ray_x, *ray_y, *ray_z;
  const float *point_x, *point_y, *point_z;
  const float *sq_threshold, *sq_sigma;
};

struct BlockScore {
  float gain = 0.0f;
  float num_inliers = 0.0f;
};

// Writes the gains of a block and sums them.
CAIRN_VECTOR_CLONES
BlockScore ScoreBlock(const BlockView& in, const FloatModel& m, float* __restrict gains) {
  float lane_gain[kNumLanes] = {}, lane_inliers[kNumLanes] = {};
  for (int begin = 0; begin < kBlock; begin += kNumLanes) {
    for (int lane = 0; lane < kNumLanes; ++lane) {
      const int i = begin + lane;
      const float x = in.point_x[i], y = in.point_y[i], z = in.point_z[i];
      const float px = m.r[0] * x + m.r[1] * y + m.r[2] * z + m.t[0];
      const float py = m.r[3] * x + m.r[4] * y + m.r[5] * z + m.t[1];
      const float pz = m.r[6] * x + m.r[7] * y + m.r[8] * z + m.t[2];
      const float cross_x = in.ray_y[i] * pz - in.ray_z[i] * py;
      const float cross_y = in.ray_z[i] * px - in.ray_x[i] * pz;
      const float cross_z = in.ray_x[i] * py - in.ray_y[i] * px;
      // Numerator and denominator of (sin e / t)^2 are both multiplied by the squared distance.
      const float sq_sine = cross_x * cross_x + cross_y * cross_y + cross_z * cross_z;
      const float sq_distance = px * px + py * py + pz * pz;
      const float sq_base = sq_distance * in.sq_threshold[i];
      const float sq_widened = std::min(sq_base + 9.0f * in.sq_sigma[i], 4.0f * sq_base);
      const float ratio = sq_sine / (sq_widened + sq_distance * m.extra_sq_rad);
      const float depth = in.ray_x[i] * px + in.ray_y[i] * py + in.ray_z[i] * pz;
      float gain = 1.0f - ratio;
      gain = gain > 0.0f ? gain : 0.0f;  // Not a number if the landmark is the camera centre: 0.
      gain = depth > 0.0f ? gain : 0.0f;
      gains[i] = gain;
      lane_gain[lane] += gain;
      lane_inliers[lane] += gain > 0.0f ? 1.0f : 0.0f;
    }
  }
  BlockScore score;
  for (int lane = 0; lane < kNumLanes; ++lane) {
    score.gain += lane_gain[lane];
    score.num_inliers += lane_inliers[lane];
  }
  return score;
}

// Wald's test of "the model is as good as the best so far" against "it is a bad one".
class SequentialTest {
 public:
  // The ratios of inliers that a good and a bad model have. Never rejects unless good > bad.
  SequentialTest(double good_inlier_ratio, double bad_inlier_ratio)
      : active_(good_inlier_ratio > bad_inlier_ratio && good_inlier_ratio < 1.0) {
    if (active_) {
      log_if_inlier_ = std::log(bad_inlier_ratio / good_inlier_ratio);
      log_if_outlier_ = std::log((1.0 - bad_inlier_ratio) / (1.0 - good_inlier_ratio));
    }
  }

  bool Rejects(double num_tested, double num_inliers) const {
    constexpr double kLogThreshold = 5.3;  // ln 200: loses at most one good model in 200.
    return active_ && num_inliers * log_if_inlier_ + (num_tested - num_inliers) * log_if_outlier_ >
                          kLogThreshold;
  }

 private:
  bool active_;
  double log_if_inlier_ = 0.0;
  double log_if_outlier_ = 0.0;
};

}  // namespace

ConsensusSet::ConsensusSet(const std::vector<RayObservation>& observations)
    : size_(static_cast<int>(observations.size())) {
  const size_t padded = (observations.size() + kBlock - 1) / kBlock * kBlock;
  for (std::vector<float>* array : {&ray_x_, &ray_y_, &ray_z_, &point_x_, &point_y_, &point_z_,
                                    &sq_threshold_, &sq_sigma_, &gains_}) {
    array->assign(padded, 0.0f);  // A zero ray has depth 0 from anywhere: never an inlier.
  }
  for (const RayObservation& observation : observations) {
    origin_in_anchor_ += observation.x_in_anchor / static_cast<double>(size_);
  }
  for (int i = 0; i < size_; ++i) {
    const RayObservation& observation = observations[i];
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
  const FloatModel model(cam_from_anchor, origin_in_anchor_, extra_sq_rad);
  const SequentialTest test(gain_to_beat / std::max(1, size_), bad_inlier_ratio_);
  double optimistic_gain = 0.0;  // Counts every observation of a keypoint.
  double num_inliers = 0.0;
  for (int begin = 0; begin < size_; begin += kBlock) {
    const BlockView block = {&ray_x_[begin],        &ray_y_[begin],   &ray_z_[begin],
                             &point_x_[begin],      &point_y_[begin], &point_z_[begin],
                             &sq_threshold_[begin], &sq_sigma_[begin]};
    const BlockScore score = ScoreBlock(block, model, &gains_[begin]);
    const int num_tested = std::min(size_, begin + kBlock);
    num_inliers += score.num_inliers;
    optimistic_gain += score.gain;
    const bool beaten = optimistic_gain + (size_ - num_tested) <= gain_to_beat;
    if (beaten || test.Rejects(num_tested, num_inliers)) {
      constexpr double kMemory = 0.95;
      bad_inlier_ratio_ = kMemory * bad_inlier_ratio_ + (1.0 - kMemory) * num_inliers / num_tested;
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
