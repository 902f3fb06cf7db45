// The served map and the one way to query it. All endpoints share it.
#ifndef CAIRN_HTTP_SERVICE_LOCALIZE_SERVICE_H_
#define CAIRN_HTTP_SERVICE_LOCALIZE_SERVICE_H_

#include <atomic>
#include <chrono>
#include <memory>
#include <string>

#include "core/features/sift/sift_extractor.h"
#include "engine/localizer.h"
#include "http/json/localize_request.h"
#include "http/json/localize_response.h"
#include "http/net/message.h"
#include "http/service/fair_gate.h"
#include "http/service/image_features.h"
#include "http/service/metrics.h"
#include "http/service/publication_time.h"
#include "http/service/served_map.h"
#include "http/service/server_options.h"

namespace cairn {

// Safe to call from any thread.
class LocalizeService {
 public:
  struct Answer {
    LocalizeRequest request;  // Empty if the body was not parsed because the turn did not come.
    LocalizeResult result;
    ServerTimes times;
  };

  // A query from its arrival to its answer.
  class Visit {
   public:
    // True if the turn did not come in time. Its answer is AnswerLate's; the body need not be
    // parsed.
    bool is_late() const {
      return turn_ != nullptr && turn_->outcome() == FairGate::Outcome::kLate;
    }

   private:
    friend class LocalizeService;
    std::shared_ptr<const ServedMap> map_;  // From the beginning to the end.
    FairGate::ClientId client_ = 0;
    std::chrono::steady_clock::time_point arrival_;
    std::unique_ptr<FairGate::Turn> turn_;  // Null until it has waited for its turn.
  };

  // Opens the map; throws as MapStore::Open.
  explicit LocalizeService(const ServerOptions& options);

  RequestLimits request_limits() const {
    return {.max_features = options_.max_features,
            .default_timeout_ms = options_.default_timeout_ms};
  }
  const ServerOptions& options() const { return options_; }
  std::shared_ptr<const ServedMap> map() const { return maps_.Current(); }
  ServedMaps& maps() { return maps_; }
  const ServedMaps& maps() const { return maps_; }
  Metrics& metrics() { return metrics_; }
  const Metrics& metrics() const { return metrics_; }

  // A query is answered in three steps: Receive; the caller parses the body; Localize. A body that
  // TakesLongToParse waits for its turn here, other queries wait in Localize. Throws HttpError
  // kUnavailable if too many requests wait.
  Visit Receive(const HttpRequest& http);
  // The answer to a visit that is late: kTimeout.
  Answer AnswerLate(const Visit& visit);
  // Sets the query's deadline (the client's timeout counts from the end of the upload), waits for
  // the turn if there are more requests than cores, extracts features if there is an image, checks
  // that the features have the map's codec, and localizes, all in the version of the map that
  // is the latest at the call; in a second one if that is pruned meanwhile. Returns kTimeout if the
  // turn does not come in time. Throws as Localizer::Localize; throws HttpError kInvalidImage,
  // kImageTooLarge, kWrongCodec, and kUnavailable if too many requests wait.
  Answer Localize(Visit visit, LocalizeRequest request);

  // Waits for the turn of a request that is no query but takes as much time: lists and payloads.
  // Throws HttpError kUnavailable if too many requests wait, or if the turn does not come within
  // the default timeout.
  std::unique_ptr<FairGate::Turn> WaitForTurn(const HttpRequest& http);

  // From now on, /readyz tells the front that the server stops soon. All requests are still
  // answered.
  void BeginDrain() { draining_ = true; }
  bool is_draining() const { return draining_; }
  PublicationTime& publication_time() { return publication_time_; }
  int num_waiting() const { return gate_.num_waiting(); }

  // From now on, requests with images that are not decoded yet fail, so that the server can stop
  // soon.
  void BeginStop() { stopping_ = true; }

 private:
  using TimePoint = std::chrono::steady_clock::time_point;

  // Waits for a turn, or until the deadline. Throws HttpError kUnavailable if too many wait.
  std::unique_ptr<FairGate::Turn> TakeTurn(FairGate::ClientId client, TimePoint deadline);
  // The features of the query's images. Makes room for other turns meanwhile. Stops at the
  // deadline. Throws HttpError kUnavailable if BeginStop was called.
  ImageFeatures ExtractInTime(const LocalizeRequest& request, FairGate::Turn* turn) const;
  Answer Compute(Visit visit, LocalizeRequest request);
  void Count(const Answer& answer);

  const ServerOptions options_;
  const SiftExtractor extractor_;  // Of the images of requests.
  ServedMaps maps_;
  Metrics metrics_;
  PublicationTime publication_time_;
  std::atomic<bool> draining_{false};
  std::atomic<bool> stopping_{false};
  FairGate gate_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_LOCALIZE_SERVICE_H_
