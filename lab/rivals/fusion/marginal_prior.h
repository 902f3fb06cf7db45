// What discarded cameras said about those that remain.
#ifndef CAIRN_LAB_RIVALS_FUSION_MARGINAL_PRIOR_H_
#define CAIRN_LAB_RIVALS_FUSION_MARGINAL_PRIOR_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

enum class PriorBlockKind { kPose, kMotion, kAlignment };

// A block of variables of a prior and the value at which the prior was linearised.
struct PriorBlock {
  // Of the present value of the variables.
  static PriorBlock Pose(WindowCamera* camera);
  static PriorBlock Motion(WindowCamera* camera);
  static PriorBlock Alignment(WindowAlignment* alignment);

  int size() const;
  double* variables() const;
  // How far the variables are from the value at linearisation, and the derivative of that by the
  // parameter block: pose (rotation on the left, position), motion, alignment (heading, position in
  // global of the pivot at linearisation).
  Eigen::VectorXd Difference() const;
  Eigen::MatrixXd DifferenceJacobian() const;

  PriorBlockKind kind = PriorBlockKind::kPose;
  WindowCamera* camera = nullptr;        // Of kPose and kMotion.
  WindowAlignment* alignment = nullptr;  // Of kAlignment.
  Rigid3d local_from_imu;                // At linearisation, of kPose.
  Eigen::Matrix<double, kMotionBlock, 1> motion = Eigen::Matrix<double, kMotionBlock, 1>::Zero();
  Rigid3d global_from_local;  // Of kAlignment.
  Eigen::Vector3d pivot_in_local = Eigen::Vector3d::Zero();
};

// residual + sqrt_information * (variables - linearisation).
struct MarginalPrior {
  std::vector<PriorBlock> blocks;
  Eigen::MatrixXd sqrt_information;  // Columns in the order of the blocks.
  Eigen::VectorXd residual;

  int size() const { return static_cast<int>(sqrt_information.cols()); }
};

// Variables of a camera known to a covariance of [theta, p, v, b_g, b_a].
MarginalPrior PriorFromCovariance(WindowCamera* camera, const Matrix15d& covariance);

// As a residual of Ceres. The prior must outlive it.
class MarginalPriorFactor final : public ceres::CostFunction {
 public:
  explicit MarginalPriorFactor(const MarginalPrior& prior);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const MarginalPrior& prior_;
};

// Sums of squares over the variables of a window, to be marginalised.
//
// residual + sum of jacobian_k * (block k), added term by term; Marginalize eliminates the leading
// blocks by a Schur complement.
class NormalEquations {
 public:
  // Blocks to be eliminated first.
  NormalEquations(std::vector<PriorBlock> blocks, int num_eliminated);

  // Offset of a block, or -1 if it is not there.
  int Offset(PriorBlockKind kind, const WindowCamera* camera) const;
  int dim() const { return static_cast<int>(gradient_.size()); }

  // Adds J' J and J' r; `columns` are offsets of the blocks whose Jacobians stand side by side.
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
