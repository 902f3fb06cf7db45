#include "engine/pose/normal_equations.h"

#include <algorithm>
#include <cmath>

#include "core/simd.h"

namespace cairn {
namespace {

constexpr int kNumLanes = NormalEquations::kNumLanes;
constexpr double kMinSqDistance = 1e-6;

CAIRN_VECTOR_CLONES void AddBatch(const NormalEquations::Batch& batch,
                                  const ResidualWeights& weights, int num_added,
                                  NormalEquations::LaneSums* sums) {
  const double sq_sigma = weights.keypoint_sigma_px * weights.keypoint_sigma_px;
  const double per_sq_scale = 1.0 / (weights.cauchy_scale * weights.cauchy_scale);
  double jacobian[2][6][kNumLanes], weighted[2][6][kNumLanes], weight[kNumLanes];
  for (int i = 0; i < kNumLanes; ++i) {
    const double x = batch.from_center[0][i], y = batch.from_center[1][i],
                 z = batch.from_center[2][i];
    const double sq_distance = std::max(kMinSqDistance, x * x + y * y + z * z);
    const double landmark_px_m = batch.landmark_px_m[i];
    const double information =
        sq_distance / (sq_sigma * sq_distance + landmark_px_m * landmark_px_m);
    const double u = batch.residual_px[0][i], v = batch.residual_px[1][i];
    const double loss = 1.0 + (u * u + v * v) * information * per_sq_scale;
    weight[i] = i < num_added ? information / loss : 0.0;
    sums->loss_product[i] *= i < num_added ? loss : 1.0;
  }
  for (int row = 0; row < 2; ++row) {
    for (int i = 0; i < kNumLanes; ++i) {
      const double x = batch.from_center[0][i], y = batch.from_center[1][i],
                   z = batch.from_center[2][i];
      const double a = batch.pixel_by_anchor[3 * row][i], b = batch.pixel_by_anchor[3 * row + 1][i],
                   c = batch.pixel_by_anchor[3 * row + 2][i];
      jacobian[row][0][i] = b * z - c * y;
      jacobian[row][1][i] = c * x - a * z;
      jacobian[row][2][i] = a * y - b * x;
      jacobian[row][3][i] = -a;
      jacobian[row][4][i] = -b;
      jacobian[row][5][i] = -c;
    }
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < kNumLanes; ++i) {
        weighted[row][j][i] = weight[i] * jacobian[row][j][i];
      }
    }
  }
  int place = 0;
  for (int j = 0; j < 6; ++j) {
    for (int k = j; k < 6; ++k, ++place) {
      for (int i = 0; i < kNumLanes; ++i) {
        sums->normal[place][i] +=
            weighted[0][j][i] * jacobian[0][k][i] + weighted[1][j][i] * jacobian[1][k][i];
      }
    }
    for (int i = 0; i < kNumLanes; ++i) {
      sums->gradient[j][i] +=
          weighted[0][j][i] * batch.residual_px[0][i] + weighted[1][j][i] * batch.residual_px[1][i];
    }
  }
}

double Sum(const NormalEquations::Lanes& lanes) {
  double sum = 0.0;
  for (const double lane : lanes) {
    sum += lane;
  }
  return sum;
}

}  // namespace

double ReprojectionInformation(const ResidualWeights& weights, double landmark_px_m,
                               double sq_distance_m) {
  const double sq_distance = std::max(kMinSqDistance, sq_distance_m);
  return sq_distance / (weights.keypoint_sigma_px * weights.keypoint_sigma_px * sq_distance +
                        landmark_px_m * landmark_px_m);
}

double RobustWeight(const ResidualWeights& weights, double sq_residual) {
  return 1.0 / (1.0 + sq_residual / (weights.cauchy_scale * weights.cauchy_scale));
}

void NormalEquations::Add(const Eigen::Matrix<double, 2, 3>& pixel_by_anchor,
                          const Eigen::Vector3d& from_center, const Eigen::Vector2d& residual_px,
                          double landmark_px_m) {
  const int lane = num_in_batch_++;
  for (int i = 0; i < 3; ++i) {
    batch_.pixel_by_anchor[i][lane] = pixel_by_anchor(0, i);
    batch_.pixel_by_anchor[3 + i][lane] = pixel_by_anchor(1, i);
    batch_.from_center[i][lane] = from_center[i];
  }
  batch_.residual_px[0][lane] = residual_px.x();
  batch_.residual_px[1][lane] = residual_px.y();
  batch_.landmark_px_m[lane] = landmark_px_m;
  if (num_in_batch_ == kNumLanes) {
    Flush();
  }
}

void NormalEquations::Flush() {
  AddBatch(batch_, weights_, num_in_batch_, &sums_);
  num_in_batch_ = 0;
  // A sum of logarithms is the logarithm of a product, so one call serves many residuals. The
  // product of eight stays in range for residuals of up to 1e18 standard deviations.
  constexpr int kBatchesPerLog = 8;
  if (++num_batches_ == kBatchesPerLog) {
    for (double& product : sums_.loss_product) {
      sum_of_logs_ += std::log(product);
      product = 1.0;
    }
    num_batches_ = 0;
  }
}

NormalEquations::Sums NormalEquations::Finish() {
  Flush();
  Sums sums;
  int place = 0;
  for (int j = 0; j < 6; ++j) {
    for (int k = j; k < 6; ++k, ++place) {
      sums.normal(j, k) = sums.normal(k, j) = Sum(sums_.normal[place]);
    }
    sums.gradient[j] = Sum(sums_.gradient[j]);
  }
  double sum_of_logs = sum_of_logs_;
  for (const double product : sums_.loss_product) {
    sum_of_logs += std::log(product);
  }
  sums.cost = 0.5 * weights_.cauchy_scale * weights_.cauchy_scale * sum_of_logs;
  return sums;
}

}  // namespace cairn
