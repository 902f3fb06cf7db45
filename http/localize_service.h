// The map being served and the one way to ask it: what the endpoints share.
#ifndef CAIRN_HTTP_LOCALIZE_SERVICE_H_
#define CAIRN_HTTP_LOCALIZE_SERVICE_H_

#include <chrono>
#include <memory>
#include <string>

#include "engine/localizer.h"
#include "http/fair_gate.h"
#include "http/json/localize_request.h"
#include "http/json/localize_response.h"
#include "http/metrics.h"
#include "http/served_map.h"
#include "http/server.h"

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

  // Fills in the query's deadline (the client's timeout counts from `arrival`), waits for its turn
  // if there are more requests than cores, extracts features if there is an image, checks that the
  // features are of the map's codec, and localizes; kTimeout if its turn does not come in time.
  // Throws HttpError kInvalidImage, kImageTooLarge, kWrongCodec, and as Localizer::Localize.
  Answer Localize(std::chrono::steady_clock::time_point arrival, LocalizeRequest* request);

 private:
  // A request has one turn, in which its image becomes features and these an answer: whoever comes
  // first is served first, with an image or without.
  Answer AnswerInTurn(const ServedMap& map, LocalizeRequest* request);

  const ServerOptions options_;
  ServedMaps maps_;
  Metrics metrics_;
  FairGate gate_;  // As many requests at a time as there are cores.
};

}  // namespace cairn

#endif  // CAIRN_HTTP_LOCALIZE_SERVICE_H_
