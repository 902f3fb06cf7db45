// The client library's face: visual-inertial tracking that drinks from the map.
//
//   auto [client, error] = FusionClient::Create(options);
//   each inertial sample:   client->AddImu({&sample, 1});
//   each camera frame:      client->AddFrame({timestamp_ns, features});
//                           if (auto query = client->PollQuery()) transport.Send(*query);
//   whenever one comes in:  client->Submit(answer);                    // from any thread
//   whenever one is drawn:  client->Predict(display_time_ns);          // from any thread
#ifndef CAIRN_FUSION_CLIENT_FUSION_CLIENT_H_
#define CAIRN_FUSION_CLIENT_FUSION_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/client/fusion_options.h"
#include "fusion/client/fusion_types.h"

namespace cairn::fusion {

enum class PredictStatus {
  kOk,
  kNoState,       // Initializing or lost.
  kTooFarAhead,   // More than half a second after the newest sample.
  kTooFarBehind,  // More than 50 ms before it.
};

struct Prediction {
  PredictStatus status = PredictStatus::kNoState;
  Estimate estimate;  // At the time asked for, if kOk.
};

// AddImu, AddFrame, PollQuery and TakeReports belong to one thread; Submit, Latest and Predict may
// be called from any, at any time. Nothing throws and nothing blocks for longer than it takes to
// move one answer. Memory is bounded by the options; AddImu allocates only where it completes a
// waiting frame. From one thread, the same calls give bit for bit the same estimates.
class FusionClient {
 public:
  struct CreateResult {
    std::unique_ptr<FusionClient> client;  // Null if the options make no sense;
    std::string error;                     // then this says which.
  };
  static CreateResult Create(const FusionOptions& options) noexcept;
  ~FusionClient();

  // In order of time. Returns the first status that is not kAccepted; the rest is processed, too.
  ImuStatus AddImu(std::span<const ImuSample> samples) noexcept;

  // The sights of a frame, in order of time. May come before the inertial samples of its instant.
  FrameStatus AddFrame(const Frame& frame) noexcept;

  // A question to the map about the newest frame, if it is time for one (QueryOptions).
  std::optional<Query> PollQuery() noexcept;

  // The map's answer, in any order and as late as may be. Taken up at the next frame; TakeReports
  // says what became of it. kQueueFull if 32 answers wait already: drop it.
  SubmitStatus Submit(Answer answer) noexcept;

  // What became of the answers since the last call; of the last 64 at most.
  std::vector<AnswerReport> TakeReports() noexcept;

  // The state at the newest inertial sample.
  Estimate Latest() const noexcept;

  // The state at a time of the imu's clock, carried on with the last rate and specific force.
  Prediction Predict(int64_t timestamp_ns) const noexcept;

 private:
  struct Impl;
  explicit FusionClient(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_FUSION_CLIENT_H_
