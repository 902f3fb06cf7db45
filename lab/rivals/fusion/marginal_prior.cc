#include "lab/rivals/fusion/marginal_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <utility>

#include "core/inertial/so3_jacobians.h"

namespace cairn::fusion {
namespace {

// Eigenvalues of the information below this fraction of the largest are rounding errors.
constexpr double kRankTolerance = 1e-13;

Eigen::Vector3d RotationDifference(const Eigen::Quaterniond& now, const Eigen::Quaterniond& then) {
  return LogSo3(now * then.conjugate());
}

}  // namespace

PriorBlock PriorBlock::Pose(WindowCamera* camera) {
  PriorBlock block;
  block.kind = PriorBlockKind::kPose;
  block.camera = camera;
  block.local_from_imu = camera->State().local_from_imu;
  return block;
}

PriorBlock PriorBlock::Motion(WindowCamera* camera) {
  PriorBlock block;
  block.kind = PriorBlockKind::kMotion;
  block.camera = camera;
  block.motion = Eigen::Map<const Eigen::Matrix<double, kMotionBlock, 1>>(camera->motion.data());
  return block;
}

PriorBlock PriorBlock::Alignment(WindowAlignment* alignment) {
  PriorBlock block;
  block.kind = PriorBlockKind::kAlignment;
  block.alignment = alignment;
  block.global_from_local = alignment->GlobalFromLocal();
  block.pivot_in_local = alignment->pivot_in_local;
  return block;
}

int PriorBlock::size() const {
  switch (kind) {
    case PriorBlockKind::kPose:
      return kPoseBlock;
    case PriorBlockKind::kMotion:
      return kMotionBlock;
    case PriorBlockKind::kAlignment:
      break;
  }
  return kGlobalBlock;
}

double* PriorBlock::variables() const {
  switch (kind) {
    case PriorBlockKind::kPose:
      return camera->pose.data();
    case PriorBlockKind::kMotion:
      return camera->motion.data();
    case PriorBlockKind::kAlignment:
      break;
  }
  return alignment->block.data();
}

Eigen::VectorXd PriorBlock::Difference() const {
  Eigen::VectorXd difference(size());
  if (kind == PriorBlockKind::kPose) {
    const Rigid3d now = camera->State().local_from_imu;
    difference << RotationDifference(now.rotation, local_from_imu.rotation),
        now.translation - local_from_imu.translation;
  } else if (kind == PriorBlockKind::kMotion) {
    difference =
        Eigen::Map<const Eigen::Matrix<double, kMotionBlock, 1>>(camera->motion.data()) - motion;
  } else {
    const Rigid3d now = alignment->GlobalFromLocal();
    difference << RotationDifference(now.rotation, global_from_local.rotation).z(),
        now * pivot_in_local - global_from_local * pivot_in_local;
  }
  return difference;
}

Eigen::MatrixXd PriorBlock::DifferenceJacobian() const {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(size(), size());
  if (kind == PriorBlockKind::kPose) {
    const Eigen::Vector3d theta = Eigen::Map<const Eigen::Vector3d>(camera->pose.data());
    jacobian.topLeftCorner<3, 3>() =
        InverseLeftJacobian(
            RotationDifference(ExpSo3(theta) * camera->reference, local_from_imu.rotation)) *
        LeftJacobian(theta);
  } else if (kind == PriorBlockKind::kAlignment) {
    const Eigen::Vector3d arm =
        alignment->GlobalFromLocal().rotation * (pivot_in_local - alignment->pivot_in_local);
    jacobian(1, 0) = -arm.y();  // e_z x arm.
    jacobian(2, 0) = arm.x();
  }
  return jacobian;
}

MarginalPrior PriorFromCovariance(WindowCamera* camera, const Matrix15d& covariance) {
  MarginalPrior prior;
  prior.blocks = {PriorBlock::Pose(camera), PriorBlock::Motion(camera)};
  Matrix15d sqrt_information = Matrix15d::Identity();
  covariance.llt().matrixL().solveInPlace(sqrt_information);
  prior.sqrt_information = sqrt_information;
  prior.residual = Eigen::VectorXd::Zero(kImuDim);
  return prior;
}

MarginalPriorFactor::MarginalPriorFactor(const MarginalPrior& prior) : prior_(prior) {
  for (const PriorBlock& block : prior.blocks) {
    mutable_parameter_block_sizes()->push_back(block.size());
  }
  set_num_residuals(static_cast<int>(prior.residual.size()));
}

bool MarginalPriorFactor::Evaluate(double const* const* /*parameters*/, double* residuals,
                                   double** jacobians) const {
  Eigen::Map<Eigen::VectorXd> residual(residuals, prior_.residual.size());
  residual = prior_.residual;
  int offset = 0;
  for (size_t i = 0; i < prior_.blocks.size(); ++i) {
    const PriorBlock& block = prior_.blocks[i];
    const auto columns = prior_.sqrt_information.middleCols(offset, block.size());
    residual.noalias() += columns * block.Difference();
    if (jacobians != nullptr && jacobians[i] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[i], residual.size(), block.size())
          .noalias() = columns * block.DifferenceJacobian();
    }
    offset += block.size();
  }
  return true;
}

NormalEquations::NormalEquations(std::vector<PriorBlock> blocks, int num_eliminated)
    : blocks_(std::move(blocks)), num_eliminated_(0) {
  int dim = 0;
  for (const PriorBlock& block : blocks_) {
    if (static_cast<int>(offsets_.size()) == num_eliminated) {
      num_eliminated_ = dim;
    }
    offsets_.push_back(dim);
    dim += block.size();
  }
  normal_ = Eigen::MatrixXd::Zero(dim, dim);
  gradient_ = Eigen::VectorXd::Zero(dim);
}

int NormalEquations::Offset(PriorBlockKind kind, const WindowCamera* camera) const {
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (blocks_[i].kind == kind &&
        (kind == PriorBlockKind::kAlignment || blocks_[i].camera == camera)) {
      return offsets_[i];
    }
  }
  return -1;
}

void NormalEquations::Add(const std::vector<int>& offsets,
                          const std::vector<Eigen::MatrixXd>& jacobians,
                          const Eigen::VectorXd& residual) {
  for (size_t a = 0; a < offsets.size(); ++a) {
    gradient_.segment(offsets[a], jacobians[a].cols()).noalias() +=
        jacobians[a].transpose() * residual;
    for (size_t b = 0; b < offsets.size(); ++b) {
      normal_.block(offsets[a], offsets[b], jacobians[a].cols(), jacobians[b].cols()).noalias() +=
          jacobians[a].transpose() * jacobians[b];
    }
  }
}

MarginalPrior NormalEquations::Marginalize() const {
  const int m = num_eliminated_;
  const int n = dim() - m;
  const Eigen::LDLT<Eigen::MatrixXd> eliminated(normal_.topLeftCorner(m, m));
  const Eigen::MatrixXd gain = eliminated.solve(normal_.topRightCorner(m, n));
  Eigen::MatrixXd normal = normal_.bottomRightCorner(n, n) - normal_.bottomLeftCorner(n, m) * gain;
  normal = (0.5 * (normal + normal.transpose())).eval();
  const Eigen::VectorXd gradient = gradient_.tail(n) - gain.transpose() * gradient_.head(m);

  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  const double smallest = kRankTolerance * std::max(0.0, values[n - 1]);
  MarginalPrior prior;
  for (const PriorBlock& block : blocks_) {
    if (Offset(block.kind, block.camera) >= m) {
      prior.blocks.push_back(block);
    }
  }
  int first = 0;
  while (first < n && !(values[first] > smallest)) {
    ++first;
  }
  const auto vectors = eigen.eigenvectors().rightCols(n - first);
  const Eigen::VectorXd roots = values.tail(n - first).cwiseSqrt();
  prior.sqrt_information = roots.asDiagonal() * vectors.transpose();
  prior.residual = roots.cwiseInverse().asDiagonal() * (vectors.transpose() * gradient);
  return prior;
}

}  // namespace cairn::fusion
