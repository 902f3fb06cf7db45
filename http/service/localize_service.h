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
#include "http/service/metrics.h"
#include "http/service/publication_time.h"
#include "http/service/served_map.h"
#include "http/service/server_options.h"

namespace cairn {

// Safe to call from any thread.
class LocalizeService {
 public:
  struct Answer {
    LocalizeRequest request;  // Without what no parser has read because the turn did not come.
    LocalizeResult result;
    ServerTimes times;
  };

  // Opens the map; throws as MapStore::Open.
  explicit LocalizeService(const ServerOptions& options);

  RequestLimits request_limits() const {
    return {.max_features = options_.max_features,
            .default_timeout_ms = options_.default_timeout_ms};
  }
  const ServerOptions& options() const { return options_; }
  // A request keeps one map from its beginning to its end.
  std::shared_ptr<const ServedMap> map() const { return maps_.Current(); }
  ServedMaps& maps() { return maps_; }
  const ServedMaps& maps() const { return maps_; }
  Metrics& metrics() { return metrics_; }
  const Metrics& metrics() const { return metrics_; }

  // Answers one request: reads the body with `parse`, sets the query's deadline (the
  // client's timeout counts from the end of the upload), waits for its turn if there are more
  // requests than cores, extracts features if there is an image, checks that the features have the
  // map's codec, and localizes. Returns kTimeout if the turn does not come in time. A body
  // that TakesLongToParse is parsed during the turn; if the turn does not come, the body is not
  // parsed. The codec is checked in the version of the map that answers. Throws as `parse` and as
  // Localizer::Localize; throws HttpError kInvalidImage, kImageTooLarge, kWrongCodec, and
  // kUnavailable if too many requests wait.
  Answer Localize(const HttpRequest& http, BodyParser& parse);

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
  // Stores the features of the query's images in the query. Makes room for other turns meanwhile.
  // Returns false if the deadline passes first. Throws HttpError kUnavailable if BeginStop was
  // called.
  bool ExtractInTime(FairGate::Turn* turn, LocalizeRequest* request, ServerTimes* times) const;
  // Parses the body. Throws unless the features have the map's codec.
  LocalizeRequest Read(const ServedMap& map, const HttpRequest& http, BodyParser& parse) const;
  Answer AnswerInTurn(const ServedMap& map, const HttpRequest& http, BodyParser& parse);

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
