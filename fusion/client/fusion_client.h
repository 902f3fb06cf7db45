// The interface of the client library: visual-inertial tracking that uses answers of the map.
//
//   auto [client, error] = FusionClient::Create(options);
//   each inertial sample:   client->AddImu({&sample, 1});
//   each camera frame:      client->AddFrame({timestamp_ns, features});
//                           if (auto query = client->PollQuery()) transport.Send(*query);
//   each answer:            client->Submit(answer);                    // from any thread
//   each drawn image:       client->Predict(display_time_ns);          // from any thread
#ifndef CAIRN_FUSION_CLIENT_FUSION_CLIENT_H_
#define CAIRN_FUSION_CLIENT_FUSION_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/estimator/fusion_options.h"
#include "fusion/estimator/fusion_types.h"

namespace cairn::fusion {

enum class PredictStatus {
  kOk,
  kNoState,       // Initializing or lost.
  kTooFarAhead,   // More than 0.5 s after the newest sample.
  kTooFarBehind,  // More than 50 ms before the newest sample.
};

struct Prediction {
  PredictStatus status = PredictStatus::kNoState;
  Estimate estimate;  // At the requested time if kOk.
};

// Call AddImu, AddFrame, PollQuery and TakeReports from one thread. Submit, Latest and Predict may
// be called from any thread at any time. No method throws. No method blocks for longer than the
// move of one answer takes. The options bound the memory; AddImu allocates only if it completes a
// waiting frame. If all calls come from one thread, the same calls give the same estimates bit for
// bit.
class FusionClient {
 public:
  struct CreateResult {
    std::unique_ptr<FusionClient> client;  // Null if the options are invalid.
    std::string error;                     // Names the invalid option.
  };
  static CreateResult Create(const FusionOptions& options) noexcept;
  ~FusionClient();

  // Takes samples in order of time. Processes all of them and returns the first status that is not
  // kAccepted.
  ImuStatus AddImu(std::span<const ImuSample> samples) noexcept;

  // Takes the features of a frame. Frames come in order of time. A frame may come before the
  // inertial samples of its time.
  FrameStatus AddFrame(const Frame& frame) noexcept;

  // Returns a query about the newest frame if a query is due (QueryOptions).
  std::optional<Query> PollQuery() noexcept;

  // Takes an answer of the map. Answers may come in any order and arbitrarily late. The next frame
  // processes the answer, and TakeReports returns its outcome. If 32 answers are already waiting,
  // returns kQueueFull and drops the answer.
  SubmitStatus Submit(Answer answer) noexcept;

  // Returns the outcomes of the answers since the last call, at most the last 64.
  std::vector<AnswerReport> TakeReports() noexcept;

  // The state at the newest inertial sample.
  Estimate Latest() const noexcept;

  // Returns the state at a time of the IMU's clock, extrapolated with the last rate and specific
  // force.
  Prediction Predict(int64_t timestamp_ns) const noexcept;

 private:
  struct Impl;
  explicit FusionClient(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_FUSION_CLIENT_H_
