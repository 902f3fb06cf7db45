#include "fusion/client/fusion_client.h"

#include <cmath>
#include <exception>
#include <utility>

#include "fusion/client/published.h"
#include "fusion/estimator/estimator.h"
#include "fusion/estimator/steady_pose.h"

namespace cairn::fusion {
namespace {

constexpr int64_t kMaxAheadNs = 500'000'000;
constexpr int64_t kMaxBehindNs = 50'000'000;

// All data that Latest and Predict need.
struct Snapshot {
  Estimate estimate;
  ImuSample last_imu;
};

// Visits every number of a snapshot, in a fixed order.
template <typename SnapshotType, typename Visitor>
void VisitNumbers(SnapshotType& snapshot, const Visitor& visit) {
  auto& estimate = snapshot.estimate;
  const auto pose = [&visit](auto& value) {
    visit(value.rotation.coeffs().data(), 4);
    visit(value.translation.data(), 3);
  };
  pose(estimate.imu.local_from_imu);
  visit(estimate.imu.velocity_in_local.data(), 3);
  visit(estimate.imu.gyro_bias.data(), 3);
  visit(estimate.imu.accel_bias.data(), 3);
  visit(estimate.covariance.data(), kImuDim * kImuDim);
  pose(estimate.global_from_local);
  visit(estimate.global_covariance.data(), 36);
  pose(estimate.global_from_imu);
  visit(estimate.global_from_imu_covariance.data(), 36);
  pose(estimate.steady_global_from_imu);
  visit(snapshot.last_imu.gyro_rad_s.data(), 3);
  visit(snapshot.last_imu.accel_m_s2.data(), 3);
}

constexpr size_t kNumNumbers = 4 * 7 + 9 + kImuDim * kImuDim + 2 * 36 + 6;
// The numbers are followed by the mode with has_global, the epoch, and the timestamp in two halves.
// Each of these is exact as a double.
using Channel = Published<kNumNumbers + 4>;

Channel::Words Pack(const Snapshot& snapshot) {
  Channel::Words words;
  size_t next = 0;
  VisitNumbers(snapshot, [&](const double* numbers, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      words[next++] = numbers[i];
    }
  });
  words[next++] = static_cast<double>(static_cast<int>(snapshot.estimate.mode) * 2 +
                                      (snapshot.estimate.has_global ? 1 : 0));
  words[next++] = static_cast<double>(snapshot.estimate.epoch);
  words[next++] = static_cast<double>(snapshot.estimate.timestamp_ns >> 32);
  words[next++] = static_cast<double>(snapshot.estimate.timestamp_ns & 0xffffffff);
  return words;
}

Snapshot Unpack(const Channel::Words& words) {
  Snapshot snapshot;
  size_t next = 0;
  VisitNumbers(snapshot, [&](double* numbers, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      numbers[i] = words[next++];
    }
  });
  const int mode = static_cast<int>(words[next++]);
  snapshot.estimate.mode = static_cast<Mode>(mode / 2);
  snapshot.estimate.has_global = mode % 2 != 0;
  snapshot.estimate.epoch = static_cast<int64_t>(words[next++]);
  const auto high = static_cast<int64_t>(words[next++]);
  snapshot.estimate.timestamp_ns = (high << 32) + static_cast<int64_t>(words[next++]);
  return snapshot;
}

// Moves an estimate to another time. The inertial reading is held constant.
void CarryOn(const ImuSample& reading, int64_t duration_ns, const FusionOptions& options,
             Estimate* estimate) {
  const ImuStep step{reading.gyro_rad_s, reading.accel_m_s2,
                     1e-9 * static_cast<double>(duration_ns)};
  const ImuState end = IntegrateImu(estimate->imu, step, options.gravity_m_s2);
  const FirstEstimate first{estimate->imu.local_from_imu.translation,
                            estimate->imu.velocity_in_local};
  const Matrix15d phi = TransitionMatrix(estimate->imu, first, end, step, options.gravity_m_s2);
  estimate->covariance = (phi * estimate->covariance * phi.transpose()).eval() +
                         ProcessNoise(options.imu_noise, std::abs(step.dt_s));
  if (estimate->has_global) {
    SteadyPose steady(options.steady);
    steady.TakeUp(estimate->timestamp_ns, estimate->steady_global_from_imu,
                  estimate->global_from_imu);
    // The motion since the estimate moves both poses alike. Its noise is small beside theirs.
    estimate->global_from_imu = estimate->global_from_local * end.local_from_imu;
    estimate->steady_global_from_imu =
        steady.Show(estimate->timestamp_ns + duration_ns, estimate->global_from_imu);
  }
  estimate->timestamp_ns += duration_ns;
  estimate->imu = end;
}

}  // namespace

struct FusionClient::Impl {
  explicit Impl(const FusionOptions& client_options) : options(client_options), estimator(options) {
    channel.Store(Pack({estimator.latest(), last_imu}));
  }

  const FusionOptions options;
  Estimator estimator;
  ImuSample last_imu;
  Channel channel;
};

FusionClient::FusionClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FusionClient::~FusionClient() = default;

FusionClient::CreateResult FusionClient::Create(const FusionOptions& options) noexcept {
  try {
    return {std::unique_ptr<FusionClient>(new FusionClient(std::make_unique<Impl>(options))), ""};
  } catch (const std::exception& error) {
    return {nullptr, error.what()};
  }
}

ImuStatus FusionClient::AddImu(std::span<const ImuSample> samples) noexcept {
  ImuStatus first_failure = ImuStatus::kAccepted;
  for (const ImuSample& sample : samples) {
    const ImuStatus status = impl_->estimator.AddImu(sample);
    if (status == ImuStatus::kAccepted || status == ImuStatus::kRestarted) {
      impl_->last_imu = sample;
    }
    if (first_failure == ImuStatus::kAccepted) {
      first_failure = status;
    }
  }
  impl_->channel.Store(Pack({impl_->estimator.latest(), impl_->last_imu}));
  return first_failure;
}

FrameStatus FusionClient::AddFrame(const Frame& frame) noexcept {
  const FrameStatus status = impl_->estimator.AddFrame(frame);
  impl_->channel.Store(Pack({impl_->estimator.latest(), impl_->last_imu}));
  return status;
}

std::optional<Query> FusionClient::PollQuery() noexcept { return impl_->estimator.PollQuery(); }

SubmitStatus FusionClient::Submit(Answer answer) noexcept {
  return impl_->estimator.Submit(std::move(answer));
}

std::vector<AnswerReport> FusionClient::TakeReports() noexcept {
  return impl_->estimator.TakeReports();
}

Estimate FusionClient::Latest() const noexcept { return Unpack(impl_->channel.Load()).estimate; }

Prediction FusionClient::Predict(int64_t timestamp_ns) const noexcept {
  const Snapshot snapshot = Unpack(impl_->channel.Load());
  Prediction prediction{PredictStatus::kOk, snapshot.estimate};
  Estimate& estimate = prediction.estimate;
  const int64_t ahead_ns = timestamp_ns - estimate.timestamp_ns;
  if (estimate.mode == Mode::kInitializing || estimate.mode == Mode::kLost) {
    prediction.status = PredictStatus::kNoState;
  } else if (ahead_ns > kMaxAheadNs) {
    prediction.status = PredictStatus::kTooFarAhead;
  } else if (ahead_ns < -kMaxBehindNs) {
    prediction.status = PredictStatus::kTooFarBehind;
  } else {
    CarryOn(snapshot.last_imu, ahead_ns, impl_->options, &estimate);
  }
  return prediction;
}

}  // namespace cairn::fusion
