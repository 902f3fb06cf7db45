#include "lab/rivals/fusion/factors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/inertial/so3_jacobians.h"
#include "lab/rivals/fusion/marginal_prior.h"
#include "support/numeric_jacobian.h"

namespace cairn::fusion {
namespace {

using cairn::testing::NumericJacobian;

constexpr double kGravity = 9.81;

Eigen::Vector3d RandomVector(double size, std::mt19937_64* rng) {
  std::normal_distribution<double> normal(0.0, size);
  return {normal(*rng), normal(*rng), normal(*rng)};
}

Rig TestRig() {
  Rig rig;
  rig.cam_from_imu = Rigid3d(ExpSo3({1.1, -0.3, 0.4}), Eigen::Vector3d(0.05, -0.02, 0.01));
  return rig;
}

// Two cameras 0.3 s apart with a landmark before them, off the optimum: theta and the biases are
// not those the references and the preintegration belong to.
class FactorsTest : public ::testing::Test {
 protected:
  FactorsTest() : rng_(7), prepare_(TestRig()) {
    for (int i = 0; i < 30; ++i) {
      steps_.push_back({RandomVector(0.8, &rng_),
                        Eigen::Vector3d(0.0, 0.0, kGravity) + RandomVector(2.0, &rng_), 0.01});
    }
    ImuState state;
    state.local_from_imu = Rigid3d(ExpSo3({0.3, -0.2, 1.4}), Eigen::Vector3d(3.0, -2.0, 1.5));
    state.velocity_in_local = {1.0, 0.4, -0.2};
    state.gyro_bias = {0.01, -0.02, 0.015};
    state.accel_bias = {0.1, 0.05, -0.08};
    Preintegration none(ImuNoise(), state.gyro_bias, state.accel_bias);
    from_ = std::make_unique<WindowCamera>(state, none);
    Preintegration motion(ImuNoise(), state.gyro_bias, state.accel_bias);
    motion.Append(steps_);
    for (const ImuStep& step : steps_) {
      state = IntegrateImu(state, step, kGravity);
    }
    to_ = std::make_unique<WindowCamera>(state, motion);
    to_->imu_sqrt_information = motion.SqrtInformation();
    alignment_.Set(Rigid3d(ExpSo3({0.0, 0.0, 2.0}), Eigen::Vector3d(100.0, 50.0, -3.0)),
                   {3.0, -2.0, 1.0});
    x_in_local_ = from_->State().local_from_imu *
                  (TestRig().cam_from_imu.Inverse() * Eigen::Vector3d(0.8, -0.5, 6.0));
    prepare_.Watch({from_.get(), to_.get()}, &alignment_);
  }

  void Disturb() {
    const auto disturb = [&](double* values, int begin, int end, double size) {
      std::normal_distribution<double> normal(0.0, size);
      for (int i = begin; i < end; ++i) {
        values[i] += normal(rng_);
      }
    };
    for (WindowCamera* camera : {from_.get(), to_.get()}) {
      disturb(camera->pose.data(), 0, 6, 0.05);
      disturb(camera->motion.data(), 0, 3, 0.1);
      disturb(camera->motion.data(), 3, 9, 0.02);
    }
    disturb(alignment_.block.data(), 0, 1, 0.1);
    disturb(alignment_.block.data(), 1, 4, 0.3);
    prepare_.Prepare();
  }

  std::vector<double*> ImuVariables() {
    return {from_->pose.data(), from_->motion.data(), to_->pose.data(), to_->motion.data()};
  }

  Eigen::VectorXd Residual(const ceres::CostFunction& factor,
                           const std::vector<double*>& variables) {
    prepare_.Prepare();
    Eigen::VectorXd residual(factor.num_residuals());
    EXPECT_TRUE(factor.Evaluate(variables.data(), residual.data(), nullptr));
    return residual;
  }

  // Largest difference between an analytic Jacobian and central differences, relative to the
  // Jacobian's largest entry.
  template <int kResiduals, int kSize>
  double JacobianError(const ceres::CostFunction& factor, const std::vector<double*>& variables,
                       int block, double step = 1e-6) {
    prepare_.Prepare();
    Eigen::VectorXd residual(factor.num_residuals());
    Eigen::Matrix<double, kResiduals, kSize, Eigen::RowMajor> analytic;
    std::vector<double*> jacobians(variables.size(), nullptr);
    jacobians[static_cast<size_t>(block)] = analytic.data();
    EXPECT_TRUE(factor.Evaluate(variables.data(), residual.data(), jacobians.data()));
    using Vector = Eigen::Matrix<double, kSize, 1>;
    Eigen::Map<Vector> values(variables[static_cast<size_t>(block)]);
    const Vector at = values;
    const auto f = [&](const Vector& delta) -> Eigen::Matrix<double, kResiduals, 1> {
      values = at + delta;
      return Residual(factor, variables);
    };
    const Eigen::Matrix<double, kResiduals, kSize> numeric =
        NumericJacobian<kResiduals, kSize>(f, step);
    values = at;
    prepare_.Prepare();
    EXPECT_GT(numeric.cwiseAbs().maxCoeff(), 0.0);
    return (analytic - numeric).cwiseAbs().maxCoeff() / numeric.cwiseAbs().maxCoeff();
  }

  std::mt19937_64 rng_;
  PrepareVariables prepare_;
  std::vector<ImuStep> steps_;
  std::unique_ptr<WindowCamera> from_;
  std::unique_ptr<WindowCamera> to_;
  WindowAlignment alignment_;
  Eigen::Vector3d x_in_local_;
};

TEST_F(FactorsTest, LocalJacobiansAreThoseOfDifferences) {
  Disturb();
  LocalFactor factor;
  factor.Set(from_.get(), {0.1, -0.05}, 0.002);
  const std::vector<double*> variables = {from_->pose.data(), x_in_local_.data()};
  EXPECT_LT((JacobianError<2, kPoseBlock>(factor, variables, 0)), 1e-7);
  EXPECT_LT((JacobianError<2, kLandmarkBlock>(factor, variables, 1)), 1e-7);
}

TEST_F(FactorsTest, LocalResidualVanishesAtTheTruth) {
  LocalFactor factor;
  factor.Set(from_.get(), Eigen::Vector2d(0.8 / 6.0, -0.5 / 6.0), 0.002);
  EXPECT_LT(Residual(factor, {from_->pose.data(), x_in_local_.data()}).norm(), 1e-9);
}

TEST_F(FactorsTest, GlobalJacobiansAreThoseOfDifferences) {
  const Eigen::Vector3d x_in_global = alignment_.GlobalFromLocal() * x_in_local_;
  Disturb();
  GlobalFactor factor;
  factor.Set(from_.get(), &alignment_, {0.1, -0.05}, 0.002, x_in_global);
  const std::vector<double*> variables = {from_->pose.data(), alignment_.block.data()};
  EXPECT_LT((JacobianError<2, kPoseBlock>(factor, variables, 0)), 1e-7);
  EXPECT_LT((JacobianError<2, kGlobalBlock>(factor, variables, 1)), 1e-7);
}

TEST_F(FactorsTest, GlobalResidualIsThatOfTheSamePointInLocal) {
  GlobalFactor global;
  global.Set(to_.get(), &alignment_, {0.1, -0.05}, 0.002,
             alignment_.GlobalFromLocal() * x_in_local_);
  LocalFactor local;
  local.Set(to_.get(), {0.1, -0.05}, 0.002);
  const Eigen::VectorXd difference = Residual(global, {to_->pose.data(), alignment_.block.data()}) -
                                     Residual(local, {to_->pose.data(), x_in_local_.data()});
  EXPECT_LT(difference.norm(), 1e-8);
}

TEST_F(FactorsTest, PointsBehindTheCameraFailTheEvaluation) {
  LocalFactor factor;
  factor.Set(from_.get(), {0.1, -0.05}, 0.002);
  prepare_.Prepare();
  Eigen::Vector3d behind = from_->State().local_from_imu *
                           (TestRig().cam_from_imu.Inverse() * Eigen::Vector3d(0.1, 0.1, -2.0));
  const double* variables[] = {from_->pose.data(), behind.data()};
  double residuals[2];
  EXPECT_FALSE(factor.Evaluate(variables, residuals, nullptr));
}

TEST_F(FactorsTest, ImuResidualVanishesForTheIntegratedState) {
  ImuFactor factor;
  factor.Set(from_.get(), to_.get(), kGravity);
  EXPECT_LT(Residual(factor, ImuVariables()).norm(), 1e-6);
}

TEST_F(FactorsTest, ImuJacobiansAreThoseOfDifferences) {
  Disturb();
  ImuFactor factor;
  factor.Set(from_.get(), to_.get(), kGravity);
  EXPECT_LT((JacobianError<15, kPoseBlock>(factor, ImuVariables(), 0)), 1e-6);
  EXPECT_LT((JacobianError<15, kMotionBlock>(factor, ImuVariables(), 1)), 1e-6);
  EXPECT_LT((JacobianError<15, kPoseBlock>(factor, ImuVariables(), 2)), 1e-6);
  EXPECT_LT((JacobianError<15, kMotionBlock>(factor, ImuVariables(), 3)), 1e-6);
}

TEST_F(FactorsTest, GaugeAndBiasJacobiansAreThoseOfDifferences) {
  Disturb();
  GaugeFactor gauge;
  gauge.Set({3.0, -2.0, 1.5}, 1e-3, 1e-2);
  EXPECT_LT((JacobianError<4, kPoseBlock>(gauge, {from_->pose.data()}, 0)), 1e-8);
  BiasFactor bias;
  bias.Set({0.01, 0.02, 0.03}, {0.1, 0.2, 0.3}, 1e-3, 2e-2);
  EXPECT_LT((JacobianError<6, kMotionBlock>(bias, {from_->motion.data()}, 0)), 1e-8);
}

TEST_F(FactorsTest, PriorJacobiansAreThoseOfDifferences) {
  MarginalPrior prior;
  prior.blocks = {PriorBlock::Pose(from_.get()), PriorBlock::Motion(from_.get()),
                  PriorBlock::Alignment(&alignment_)};
  prior.sqrt_information = Eigen::MatrixXd::Random(12, 19);
  prior.residual = Eigen::VectorXd::Random(12);
  // Other references than those of the prior.
  Disturb();
  from_->Rebase();
  alignment_.Set(alignment_.GlobalFromLocal(), {-4.0, 5.0, 2.0});
  Disturb();
  const MarginalPriorFactor factor(prior);
  const std::vector<double*> variables = {from_->pose.data(), from_->motion.data(),
                                          alignment_.block.data()};
  EXPECT_LT((JacobianError<12, kPoseBlock>(factor, variables, 0)), 1e-7);
  EXPECT_LT((JacobianError<12, kMotionBlock>(factor, variables, 1)), 1e-7);
  EXPECT_LT((JacobianError<12, kGlobalBlock>(factor, variables, 2)), 1e-7);
}

TEST_F(FactorsTest, PreintegrationOfTwoHalvesIsThatOfTheWhole) {
  const std::span<const ImuStep> steps = steps_;
  Preintegration whole(ImuNoise(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  whole.Append(steps);
  Preintegration halves(ImuNoise(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  halves.Append(steps.first(12));
  halves.Append(steps.subspan(12));
  EXPECT_LT(
      (whole.delta().local_from_imu.translation - halves.delta().local_from_imu.translation).norm(),
      1e-12);
  EXPECT_LT((whole.SqrtInformation() - halves.SqrtInformation()).norm(),
            1e-9 * whole.SqrtInformation().norm());
}

TEST_F(FactorsTest, PreintegrationFollowsBiasesToFirstOrder) {
  const Eigen::Vector3d gyro_change(1e-4, -2e-4, 1.5e-4);
  const Eigen::Vector3d accel_change(1e-3, 2e-3, -1e-3);
  Preintegration before(ImuNoise(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  before.Append(steps_);
  Preintegration after = before;
  after.Reintegrate(gyro_change, accel_change);
  Eigen::Matrix<double, 6, 1> change;
  change << gyro_change, accel_change;
  const Eigen::Matrix<double, 9, 1> predicted = before.ByBiases() * change;
  const Eigen::Quaterniond turn =
      after.delta().local_from_imu.rotation * before.delta().local_from_imu.rotation.conjugate();
  EXPECT_LT((LogSo3(turn) - predicted.head<3>()).norm(), 1e-3 * predicted.head<3>().norm());
  EXPECT_LT((after.delta().local_from_imu.translation - before.delta().local_from_imu.translation -
             predicted.segment<3>(3))
                .norm(),
            1e-3 * predicted.segment<3>(3).norm());
  EXPECT_LT(
      (after.delta().velocity_in_local - before.delta().velocity_in_local - predicted.tail<3>())
          .norm(),
      1e-3 * predicted.tail<3>().norm());
}

// With the noise whitened, residuals of noisy integrations have unit covariance.
TEST_F(FactorsTest, ImuResidualsOfNoisySamplesAreWhite) {
  const ImuNoise noise;
  std::normal_distribution<double> normal;
  ImuFactor factor;
  factor.Set(from_.get(), to_.get(), kGravity);
  const ImuState start = from_->State();
  constexpr int kNumRuns = 400;
  Eigen::Matrix<double, 9, 1> sq_sum = Eigen::Matrix<double, 9, 1>::Zero();
  for (int run = 0; run < kNumRuns; ++run) {
    ImuState state = start;
    for (ImuStep step : steps_) {
      const double root_rate = 1.0 / std::sqrt(step.dt_s);
      step.gyro_rad_s += RandomVector(noise.gyro_density * root_rate, &rng_);
      step.accel_m_s2 += RandomVector(noise.accel_density * root_rate, &rng_);
      state = IntegrateImu(state, step, kGravity);
    }
    to_->SetState(state);
    sq_sum += Residual(factor, ImuVariables()).head<9>().cwiseAbs2();
  }
  const Eigen::Matrix<double, 9, 1> variance = sq_sum / kNumRuns;
  EXPECT_GT(variance.minCoeff(), 0.75);
  EXPECT_LT(variance.maxCoeff(), 1.3);
}

TEST(So3Jacobians, AreInverseToEachOther) {
  for (const Eigen::Vector3d& x :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(1e-3, -2e-3, 5e-4),
        Eigen::Vector3d(0.9, -1.1, 0.4), Eigen::Vector3d(1.9, 1.7, -1.2)}) {
    EXPECT_LT((LeftJacobian(x) * InverseLeftJacobian(x) - Eigen::Matrix3d::Identity()).norm(),
              1e-9);
  }
}

TEST(So3Jacobians, LeftJacobianIsThatOfDifferences) {
  const Eigen::Vector3d x(0.7, -0.4, 1.1);
  const auto numeric = NumericJacobian<3, 3>([&](const Eigen::Vector3d& delta) -> Eigen::Vector3d {
    return LogSo3(ExpSo3(x + delta) * ExpSo3(x).conjugate());
  });
  EXPECT_LT((numeric - LeftJacobian(x)).norm(), 1e-8);
}

}  // namespace
}  // namespace cairn::fusion
