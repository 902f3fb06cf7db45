#include "fusion/client/fusion_client.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <tuple>
#include <type_traits>
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

// References to all matrices of a snapshot, in a fixed order.
template <typename SnapshotType>
auto MatricesOf(SnapshotType& snapshot) {
  auto& estimate = snapshot.estimate;
  const auto pose = [](auto& value) {
    return std::tie(value.rotation.coeffs(), value.translation);
  };
  return std::tuple_cat(pose(estimate.imu.local_from_imu),
                        std::tie(estimate.imu.velocity_in_local, estimate.imu.gyro_bias,
                                 estimate.imu.accel_bias, estimate.covariance),
                        pose(estimate.global_from_local), std::tie(estimate.global_covariance),
                        pose(estimate.global_from_imu),
                        std::tie(estimate.global_from_imu_covariance),
                        pose(estimate.steady_global_from_imu),
                        std::tie(snapshot.last_imu.gyro_rad_s, snapshot.last_imu.accel_m_s2));
}

template <typename... Matrices>
constexpr size_t CountNumbers(std::type_identity<std::tuple<Matrices&...>>) {
  static_assert(((Matrices::SizeAtCompileTime > 0) && ...), "each matrix has a fixed size");
  return (size_t{Matrices::SizeAtCompileTime} + ...);
}
constexpr size_t kNumNumbers =
    CountNumbers(std::type_identity<decltype(MatricesOf(std::declval<Snapshot&>()))>());

// The rest of a snapshot: the mode with has_global, the epoch, and the timestamp in two halves.
// Each of these is exact as a double.
using Scalars = std::array<double, 4>;

Scalars ScalarsOf(const Estimate& estimate) {
  return {static_cast<double>(static_cast<int>(estimate.mode) * 2 + (estimate.has_global ? 1 : 0)),
          static_cast<double>(estimate.epoch), static_cast<double>(estimate.timestamp_ns >> 32),
          static_cast<double>(estimate.timestamp_ns & 0xffffffff)};
}

void SetScalars(const Scalars& scalars, Estimate* estimate) {
  const auto [mode, epoch, high, low] = scalars;
  estimate->mode = static_cast<Mode>(static_cast<int>(mode) / 2);
  estimate->has_global = static_cast<int>(mode) % 2 != 0;
  estimate->epoch = static_cast<int64_t>(epoch);
  estimate->timestamp_ns = (static_cast<int64_t>(high) << 32) + static_cast<int64_t>(low);
}

using Channel = Published<kNumNumbers + std::tuple_size_v<Scalars>>;

Channel::Words Pack(const Snapshot& snapshot) {
  Channel::Words words;
  auto* next = words.data();
  const auto write = [&](const auto& numbers) {
    next = std::copy_n(numbers.data(), numbers.size(), next);
  };
  std::apply([&](const auto&... matrices) { (write(matrices), ...); }, MatricesOf(snapshot));
  write(ScalarsOf(snapshot.estimate));
  return words;
}

Snapshot Unpack(const Channel::Words& words) {
  Snapshot snapshot;
  const auto* next = words.data();
  const auto read = [&](auto& numbers) {
    std::copy_n(next, numbers.size(), numbers.data());
    next += numbers.size();
  };
  std::apply([&](auto&... matrices) { (read(matrices), ...); }, MatricesOf(snapshot));
  Scalars scalars;
  read(scalars);
  SetScalars(scalars, &snapshot.estimate);
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
