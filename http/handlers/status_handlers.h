// Endpoints for the state of the server (health, metrics, version) and its embedded pages.
#ifndef CAIRN_HTTP_HANDLERS_STATUS_HANDLERS_H_
#define CAIRN_HTTP_HANDLERS_STATUS_HANDLERS_H_

#include <functional>
#include <string_view>

#include "http/net/message.h"
#include "http/service/localize_service.h"

namespace cairn {

// GET /livez: 200 as long as the process answers.
HttpResponse HandleLive();
// GET /readyz: 200 if the map can be read and the server does not drain, else 503.
HttpResponse HandleReady(const LocalizeService& service);
// GET /healthz: 200 if the map can be read, else 503; with the map version and the cache.
HttpResponse HandleHealth(const LocalizeService& service);
// GET /metrics: Prometheus text.
HttpResponse HandleMetrics(LocalizeService* service);
// GET /version: program, map, codec and limits.
HttpResponse HandleVersion(const LocalizeService& service);

// Sends browsers to another page. `location` is relative to the page of the request, because a
// front may serve the API under a prefix of the path.
HttpResponse Redirect(const char* location);

// Answers each request with an embedded file.
std::function<HttpResponse(const HttpRequest&)> Asset(std::string_view content,
                                                      const char* content_type);

}  // namespace cairn

#endif  // CAIRN_HTTP_HANDLERS_STATUS_HANDLERS_H_
