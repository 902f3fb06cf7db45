#include "fusion/client/fusion_client.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <set>
#include <span>
#include <thread>
#include <vector>

#include "fusion/client/published.h"
#include "fusion/estimator/estimator.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

// A walk that begins at rest, so that the client starts on its own.
Simulation WalkFromRest(uint64_t seed = 1) {
  SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = 12.0;
  options.walk.start_stop_s = {2.0};
  return Simulation(options);
}

// Runs the client over the simulation; answers come two frames late.
template <typename Client, typename Callback>
void Feed(const Simulation& simulation, Client* client, const Callback& after_frame) {
  size_t next_imu = 0;
  std::vector<std::pair<size_t, Answer>> in_flight;
  for (size_t i = 0; i < simulation.frames().size(); ++i) {
    const SimulatedFrame& frame = simulation.frames()[i];
    size_t end = next_imu;
    while (end < simulation.imu().size() &&
           simulation.imu()[end].timestamp_ns <= frame.truth.timestamp_ns) {
      ++end;
    }
    client->AddImu(std::span(simulation.imu()).subspan(next_imu, end - next_imu));
    next_imu = end;
    client->AddFrame({frame.truth.timestamp_ns, frame.features});
    if (const auto query = client->PollQuery()) {
      in_flight.emplace_back(i + 2, simulation.MakeAnswer(*query, i, {}));
    }
    if (!in_flight.empty() && in_flight.front().first <= i) {
      client->Submit(in_flight.front().second);
      in_flight.erase(in_flight.begin());
    }
    after_frame(i);
  }
}

TEST(FusionClient, RefusesNonsenseWithoutThrowing) {
  FusionOptions options;
  options.max_clones = 1;
  const auto result = FusionClient::Create(options);
  EXPECT_EQ(result.client, nullptr);
  EXPECT_NE(result.error.find("max_clones"), std::string::npos);
}

TEST(FusionClient, StartsAtRestAndFindsTheMap) {
  const Simulation simulation = WalkFromRest();
  const auto [client, error] = FusionClient::Create(simulation.MatchingFusionOptions());
  ASSERT_NE(client, nullptr) << error;
  EXPECT_EQ(client->Latest().mode, Mode::kInitializing);
  EXPECT_EQ(client->Predict(0).status, PredictStatus::kNoState);
  bool was_tracking = false;
  Feed(simulation, client.get(),
       [&](size_t) { was_tracking |= client->Latest().mode == Mode::kTracking; });
  EXPECT_TRUE(was_tracking);
  const Estimate estimate = client->Latest();
  EXPECT_EQ(estimate.mode, Mode::kLocalized);
  const FrameTruth& truth = simulation.frames().back().truth;
  EXPECT_LT((estimate.global_from_imu.translation - truth.world_from_imu.translation).norm(), 0.05);
  EXPECT_LT(RotationAngleRad(estimate.global_from_imu.rotation, truth.world_from_imu.rotation),
            0.01);
  EXPECT_LT((estimate.global_from_local * estimate.imu.local_from_imu.translation -
             estimate.global_from_imu.translation)
                .norm(),
            1e-9);
}

TEST(FusionClient, PredictsAHundredMillisecondsAhead) {
  const Simulation simulation = WalkFromRest();
  const auto [client, error] = FusionClient::Create(simulation.MatchingFusionOptions());
  ASSERT_NE(client, nullptr) << error;
  Prediction prediction;
  const size_t last = simulation.frames().size() - 1;
  Feed(simulation, client.get(), [&](size_t i) {
    if (i + 1 == last) {
      prediction = client->Predict(simulation.frames()[last].truth.timestamp_ns);
    }
  });
  ASSERT_EQ(prediction.status, PredictStatus::kOk);
  const FrameTruth& truth = simulation.frames()[last].truth;
  EXPECT_LT(
      (prediction.estimate.global_from_imu.translation - truth.world_from_imu.translation).norm(),
      0.08);
  const int64_t now_ns = client->Latest().timestamp_ns;
  EXPECT_EQ(client->Predict(now_ns + 600'000'000).status, PredictStatus::kTooFarAhead);
  EXPECT_EQ(client->Predict(now_ns - 60'000'000).status, PredictStatus::kTooFarBehind);
}

TEST(FusionClient, PredictsWhatIsHeldBackOfTheCorrectionsAsWell) {
  const Simulation simulation = WalkFromRest();
  FusionOptions options = simulation.MatchingFusionOptions();
  options.steady.time_constant_s = 5.0;
  const auto [client, error] = FusionClient::Create(options);
  ASSERT_NE(client, nullptr) << error;
  Feed(simulation, client.get(), [](size_t) {});
  const Estimate now = client->Latest();
  const auto held_back_m = [](const Estimate& estimate) {
    return Eigen::Vector3d(estimate.steady_global_from_imu.translation -
                           estimate.global_from_imu.translation);
  };
  ASSERT_GT(held_back_m(now).norm(), 1e-3);
  EXPECT_LT((held_back_m(client->Predict(now.timestamp_ns).estimate) - held_back_m(now)).norm(),
            1e-12);
  const Prediction later = client->Predict(now.timestamp_ns + 500'000'000);
  ASSERT_EQ(later.status, PredictStatus::kOk);
  EXPECT_LT((held_back_m(later.estimate) - std::exp(-0.1) * held_back_m(now)).norm(), 1e-9);
}

TEST(FusionClient, ReplaysBitForBit) {
  const Simulation simulation = WalkFromRest();
  Estimate estimates[2];
  for (Estimate& estimate : estimates) {
    const auto [client, error] = FusionClient::Create(simulation.MatchingFusionOptions());
    ASSERT_NE(client, nullptr) << error;
    Feed(simulation, client.get(), [](size_t) {});
    estimate = client->Latest();
  }
  EXPECT_EQ(estimates[0].imu.local_from_imu.translation,
            estimates[1].imu.local_from_imu.translation);
  EXPECT_EQ(estimates[0].covariance, estimates[1].covariance);
  EXPECT_EQ(estimates[0].global_from_imu.rotation.coeffs(),
            estimates[1].global_from_imu.rotation.coeffs());
  EXPECT_EQ(estimates[0].steady_global_from_imu.rotation.coeffs(),
            estimates[1].steady_global_from_imu.rotation.coeffs());
  EXPECT_EQ(estimates[0].steady_global_from_imu.translation,
            estimates[1].steady_global_from_imu.translation);
}

// The client's estimator alone.
struct BareEstimator : Estimator {
  using Estimator::Estimator;
  void AddImu(std::span<const ImuSample> samples) {
    for (const ImuSample& sample : samples) {
      Estimator::AddImu(sample);
    }
  }
};

void ExpectSame(const Rigid3d& a, const Rigid3d& b) {
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  EXPECT_EQ(a.translation, b.translation);
}

// The structured bindings name every member, so that a new one does not compile until it is
// compared here.
TEST(FusionClient, PublishesTheWholeEstimate) {
  const Simulation simulation = WalkFromRest();
  FusionOptions options = simulation.MatchingFusionOptions();
  options.steady.time_constant_s = 5.0;
  const auto [client, error] = FusionClient::Create(options);
  ASSERT_NE(client, nullptr) << error;
  BareEstimator estimator(options);
  Feed(simulation, client.get(), [](size_t) {});
  Feed(simulation, &estimator, [](size_t) {});
  const Estimate published = client->Latest();
  const auto& [mode, timestamp_ns, epoch, imu, covariance, has_global, global_from_local,
               global_covariance, global_from_imu, global_from_imu_covariance,
               steady_global_from_imu] = estimator.latest();
  ASSERT_TRUE(has_global);
  EXPECT_EQ(published.mode, mode);
  EXPECT_EQ(published.timestamp_ns, timestamp_ns);
  EXPECT_EQ(published.epoch, epoch);
  const auto& [local_from_imu, velocity_in_local, gyro_bias, accel_bias] = imu;
  ExpectSame(published.imu.local_from_imu, local_from_imu);
  EXPECT_EQ(published.imu.velocity_in_local, velocity_in_local);
  EXPECT_EQ(published.imu.gyro_bias, gyro_bias);
  EXPECT_EQ(published.imu.accel_bias, accel_bias);
  EXPECT_EQ(published.covariance, covariance);
  EXPECT_EQ(published.has_global, has_global);
  ExpectSame(published.global_from_local, global_from_local);
  EXPECT_EQ(published.global_covariance, global_covariance);
  ExpectSame(published.global_from_imu, global_from_imu);
  EXPECT_EQ(published.global_from_imu_covariance, global_from_imu_covariance);
  ExpectSame(published.steady_global_from_imu, steady_global_from_imu);
}

TEST(FusionClient, ServesReadersAndSubmittersOnOtherThreads) {
  const Simulation simulation = WalkFromRest();
  const auto created = FusionClient::Create(simulation.MatchingFusionOptions());
  FusionClient* client = created.client.get();
  ASSERT_NE(client, nullptr) << created.error;
  std::atomic<bool> done{false};
  std::atomic<int> num_bad{0};
  std::thread reader([&] {
    int64_t newest_ns = 0;
    while (!done) {
      const Estimate estimate = client->Latest();
      num_bad += estimate.timestamp_ns < newest_ns;
      num_bad += std::abs(estimate.imu.local_from_imu.rotation.norm() - 1.0) > 1e-6;
      newest_ns = estimate.timestamp_ns;
    }
  });
  std::thread submitter([&] {
    for (int i = 0; i < 1000; ++i) {
      Answer stranger;
      stranger.query_id = 1'000'000 + i;
      client->Submit(stranger);
    }
  });
  Feed(simulation, client, [](size_t) {});
  submitter.join();
  done = true;
  reader.join();
  EXPECT_EQ(num_bad, 0);
  EXPECT_EQ(client->Latest().mode, Mode::kLocalized);
}

// Between two frames, more than the client has room for.
TEST(FusionClient, ReportsEveryAnswerThatItQueued) {
  const Simulation simulation = WalkFromRest();
  const auto created = FusionClient::Create(simulation.MatchingFusionOptions());
  FusionClient* client = created.client.get();
  ASSERT_NE(client, nullptr) << created.error;
  constexpr int64_t kFirstId = 1'000'000;
  int num_queued = 0, num_reported = 0;
  const size_t middle = simulation.frames().size() / 2;
  Feed(simulation, client, [&](size_t frame) {
    for (int i = 0; frame == middle && i < 60; ++i) {
      Answer stranger;
      stranger.query_id = kFirstId + i;
      num_queued += client->Submit(stranger) == SubmitStatus::kQueued;
    }
    for (const AnswerReport& report : client->TakeReports()) {
      num_reported += report.query_id >= kFirstId;
    }
  });
  EXPECT_EQ(num_queued, 32);
  EXPECT_EQ(num_reported, num_queued);
}

// As many answers as the client has room for wait when `local` restarts.
TEST(FusionClient, ReportsTheAnswersThatWaitedDuringARestart) {
  const Simulation simulation = WalkFromRest();
  const auto created = FusionClient::Create(simulation.MatchingFusionOptions());
  FusionClient* client = created.client.get();
  ASSERT_NE(client, nullptr) << created.error;
  Feed(simulation, client, [&](size_t) { client->TakeReports(); });
  constexpr int64_t kFirstId = 1'000'000;
  std::multiset<int64_t> queued, reported;
  Answer stranger;
  for (stranger.query_id = kFirstId; stranger.query_id < kFirstId + 70; ++stranger.query_id) {
    if (client->Submit(stranger) == SubmitStatus::kQueued) {
      queued.insert(stranger.query_id);
    }
  }
  EXPECT_EQ(queued.size(), 32u);

  ImuSample rest{simulation.imu().back().timestamp_ns + 2'000'000'000, Eigen::Vector3d::Zero(),
                 Eigen::Vector3d(0.0, 0.0, 9.81)};
  EXPECT_EQ(client->AddImu({&rest, 1}), ImuStatus::kRestarted);
  for (int i = 1; i < 800; ++i) {
    rest.timestamp_ns += 5'000'000;
    EXPECT_EQ(client->AddImu({&rest, 1}), ImuStatus::kAccepted);
    if (i % 20 == 0) {
      client->AddFrame({rest.timestamp_ns, {}});
    }
    for (const AnswerReport& report : client->TakeReports()) {
      if (report.query_id >= kFirstId) {
        EXPECT_EQ(report.outcome, AnswerOutcome::kUnknownQuery);
        reported.insert(report.query_id);
      }
    }
  }
  EXPECT_EQ(client->Latest().mode, Mode::kTracking);
  EXPECT_EQ(reported, queued);
}

TEST(Published, ReadersNeverSeeHalfAValue) {
  Published<64> channel;
  std::atomic<bool> done{false};
  std::atomic<int> num_torn{0};
  std::thread reader([&] {
    while (!done) {
      const auto words = channel.Load();
      for (const double word : words) {
        num_torn += word != words[0];
      }
    }
  });
  for (int i = 0; i < 20000; ++i) {
    Published<64>::Words words;
    words.fill(i);
    channel.Store(words);
  }
  done = true;
  reader.join();
  EXPECT_EQ(num_torn, 0);
  EXPECT_EQ(channel.Load()[0], 19999.0);
}

}  // namespace
}  // namespace cairn::fusion::testing
