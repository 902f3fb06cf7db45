// How the server is: health, metrics, version; and its embedded pages.
#ifndef CAIRN_HTTP_HANDLERS_STATUS_HANDLERS_H_
#define CAIRN_HTTP_HANDLERS_STATUS_HANDLERS_H_

#include <string_view>

#include "http/net/message.h"
#include "http/service/localize_service.h"

namespace cairn {

// GET /livez: the process answers.
HttpResponse HandleLive();
// GET /readyz: the map can be read; else 503.
HttpResponse HandleReady(const LocalizeService& service);
// GET /healthz: as /readyz, with map version and cache.
HttpResponse HandleHealth(const LocalizeService& service);
// GET /metrics: Prometheus text.
HttpResponse HandleMetrics(const LocalizeService& service);
// GET /version: the program, the map, the codec, the limits.
HttpResponse HandleVersion(const LocalizeService& service);

// An embedded file.
HttpResponse Asset(std::string_view content, const char* content_type);

}  // namespace cairn

#endif  // CAIRN_HTTP_HANDLERS_STATUS_HANDLERS_H_
