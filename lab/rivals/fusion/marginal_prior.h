// The information that discarded cameras leave about the remaining ones.
#ifndef CAIRN_LAB_RIVALS_FUSION_MARGINAL_PRIOR_H_
#define CAIRN_LAB_RIVALS_FUSION_MARGINAL_PRIOR_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

enum class PriorBlockKind { kPose, kMotion, kAlignment };

// A block of variables of a prior, and the value at which the prior was linearized.
struct PriorBlock {
  // A block at the present value of the variables.
  static PriorBlock Pose(WindowCamera* camera);
  static PriorBlock Motion(WindowCamera* camera);
  static PriorBlock Alignment(WindowAlignment* alignment);

  int size() const;
  double* variables() const;
  // Difference returns the variables minus their values at the linearization. DifferenceJacobian
  // returns its derivative by the parameter block. Order of the difference: for a pose, rotation
  // (on the left) and position; for an alignment, heading and the position in global of the pivot
  // at the linearization.
  Eigen::VectorXd Difference() const;
  Eigen::MatrixXd DifferenceJacobian() const;

  PriorBlockKind kind = PriorBlockKind::kPose;
  WindowCamera* camera = nullptr;        // Set for kPose and kMotion.
  WindowAlignment* alignment = nullptr;  // Set for kAlignment.
  Rigid3d local_from_imu;                // Set for kPose; value at the linearization.
  Eigen::Matrix<double, kMotionBlock, 1> motion = Eigen::Matrix<double, kMotionBlock, 1>::Zero();
  Rigid3d global_from_local;  // Set for kAlignment.
  Eigen::Vector3d pivot_in_local = Eigen::Vector3d::Zero();
};

// The prior: residual + sqrt_information * (variables - linearization).
struct MarginalPrior {
  std::vector<PriorBlock> blocks;
  Eigen::MatrixXd sqrt_information;  // Columns in the order of the blocks.
  Eigen::VectorXd residual;

  int size() const { return static_cast<int>(sqrt_information.cols()); }
};

// Returns the prior for a camera whose [theta, p, v, b_g, b_a] has the given covariance.
MarginalPrior PriorFromCovariance(WindowCamera* camera, const Matrix15d& covariance);

// The prior as a residual for Ceres. The prior must outlive the factor.
class MarginalPriorFactor final : public ceres::CostFunction {
 public:
  explicit MarginalPriorFactor(const MarginalPrior& prior);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const MarginalPrior& prior_;
};

// Sums of squares over the variables of a window, for marginalization.
//
// Terms of the form residual + sum of jacobian_k * (block k) are added one by one. Marginalize then
// eliminates the leading blocks by a Schur complement.
class NormalEquations {
 public:
  // `blocks` starts with the blocks to eliminate.
  NormalEquations(std::vector<PriorBlock> blocks, int num_eliminated);

  // Returns the offset of a block, or -1 if there is no such block.
  int Offset(PriorBlockKind kind, const WindowCamera* camera) const;
  int dim() const { return static_cast<int>(gradient_.size()); }

  // Adds J' J and J' r. J consists of `jacobians` side by side; `offsets` are the offsets of their
  // blocks.
  void Add(const std::vector<int>& offsets, const std::vector<Eigen::MatrixXd>& jacobians,
           const Eigen::VectorXd& residual);

  MarginalPrior Marginalize() const;

 private:
  std::vector<PriorBlock> blocks_;
  std::vector<int> offsets_;
  int num_eliminated_;
  Eigen::MatrixXd normal_;
  Eigen::VectorXd gradient_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_MARGINAL_PRIOR_H_
