// The map being served and the one way to ask it: what the endpoints share.
#ifndef CAIRN_HTTP_SERVICE_LOCALIZE_SERVICE_H_
#define CAIRN_HTTP_SERVICE_LOCALIZE_SERVICE_H_

#include <atomic>
#include <chrono>
#include <memory>
#include <string>

#include "engine/localizer.h"
#include "http/json/localize_request.h"
#include "http/json/localize_response.h"
#include "http/net/message.h"
#include "http/service/fair_gate.h"
#include "http/service/metrics.h"
#include "http/service/served_map.h"
#include "http/service/server_options.h"

namespace cairn {

// Safe to call from any thread.
class LocalizeService {
 public:
  struct Answer {
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
  // A request holds one map from its beginning to its end.
  std::shared_ptr<const ServedMap> map() const { return maps_.Current(); }
  ServedMaps& maps() { return maps_; }
  const ServedMaps& maps() const { return maps_; }
  Metrics& metrics() { return metrics_; }
  const Metrics& metrics() const { return metrics_; }

  // Reads the body into `request` with `parse`, fills in the query's deadline (the client's timeout
  // counts from the arrival), waits for its turn if there are more requests than cores, extracts
  // features if there is an image, checks that the features are of the map's codec, and localizes.
  // kTimeout if the turn does not come in time. A long JSON body is parsed in its turn, and is not
  // parsed at all if that does not come: `request` then stays as it is. Throws as `parse`,
  // HttpError kInvalidImage, kImageTooLarge, kWrongCodec, and as Localizer::Localize.
  Answer Localize(const HttpRequest& http, BodyParser* parse, LocalizeRequest* request);

  // From now on images are given up instead of decoded, so that the server can stop soon.
  void BeginStop() { stopping_ = true; }

 private:
  // Gives the query the features of its images; false if the deadline passes first. Throws
  // HttpError kUnavailable if BeginStop was called.
  bool ExtractInTime(LocalizeRequest* request, ServerTimes* times) const;
  // Parses the body; throws if its features are not of the map's codec.
  void Read(const ServedMap& map, const HttpRequest& http, BodyParser* parse,
            LocalizeRequest* request) const;
  Answer AnswerInTurn(const ServedMap& map, const HttpRequest& http, BodyParser* parse,
                      LocalizeRequest* request);

  const ServerOptions options_;
  ServedMaps maps_;
  Metrics metrics_;
  std::atomic<bool> stopping_{false};
  FairGate gate_;  // As many requests at a time as there are cores.
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_LOCALIZE_SERVICE_H_
