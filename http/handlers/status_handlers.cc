#include "http/handlers/status_handlers.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/angles.h"
#include "core/logging.h"
#include "core/wire/problem.h"
#include "http/handlers/compact_response.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

// Returns the latest version of the map. Throws HttpError kUnavailable if the map cannot be read.
MapSnapshot RequireReadableMap(const ServedMap& map) {
  try {
    return map.store().Snapshot();
  } catch (const Error& e) {
    LogError("the map cannot be read: {}", e.what());
    throw HttpError(ProblemCode::kUnavailable, "the map cannot be read; see the server's log");
  }
}

// Returns nothing if the map cannot be read. The other metrics are still needed then.
std::optional<ServerState::Head> HeadOf(const ServedMap& map, LocalizeService* service) {
  try {
    const MapSnapshot snapshot = map.store().Snapshot();
    return ServerState::Head{
        .version = snapshot.version(),
        .created_unix_s = service->publication_time().UnixSecondsOf(snapshot, map.created_at),
        .is_stale = snapshot.is_stale()};
  } catch (const Error& e) {
    LogError("the map cannot be read: {}", e.what());
    return std::nullopt;
  }
}

// Returns the reason why answers may be out of date, or an empty text.
std::string ProblemOf(const LocalizeService& service, const MapSnapshot& snapshot) {
  const std::string problem = service.maps().Problem();
  return problem.empty() && snapshot.is_stale()
             ? "PostgreSQL is silent; answers come from the caches of the server"
             : problem;
}

Json BoundsJson(const std::optional<GeoBox>& bounds) {
  if (!bounds) {
    return nullptr;
  }
  return {bounds->west_rad * kDegPerRad, bounds->south_rad * kDegPerRad,
          bounds->east_rad * kDegPerRad, bounds->north_rad * kDegPerRad};
}

}  // namespace

HttpResponse HandleLive() { return HttpResponse::Json(R"({"status":"ok"})"); }

HttpResponse HandleReady(const LocalizeService& service) {
  if (service.is_draining()) {
    throw HttpError(ProblemCode::kUnavailable, "the server is draining: it will stop soon");
  }
  RequireReadableMap(*service.map());
  return HttpResponse::Json(R"({"status":"ok"})");
}

HttpResponse HandleHealth(const LocalizeService& service) {
  const std::shared_ptr<const ServedMap> map = service.map();
  const MapSnapshot snapshot = RequireReadableMap(*map);
  const CacheStats cache = map->localizer->cache()->Stats();
  const std::string problem = ProblemOf(service, snapshot);
  Json json = {
      {"status", problem.empty() ? "ok" : "degraded"},
      {"map", {{"version", Value(snapshot.version())}, {"created", map->created_at}}},
      {"cache",
       {{"tiles", cache.num_entries}, {"bytes", cache.bytes}, {"maxBytes", cache.max_bytes}}}};
  if (!problem.empty()) {
    json["problem"] = problem;
  }
  return HttpResponse::Json(json.dump());
}

HttpResponse HandleMetrics(LocalizeService* service) {
  const std::shared_ptr<const ServedMap> map = service->map();
  const ServerState state{.cache = map->localizer->cache()->Stats(),
                          .head = HeadOf(*map, service),
                          .is_degraded = !service->maps().Problem().empty(),
                          .is_draining = service->is_draining(),
                          .num_waiting = service->num_waiting()};
  return {.status = 200,
          .content_type = "text/plain; version=0.0.4",
          .body = service->metrics().Render(state),
          .headers = {}};
}

HttpResponse HandleVersion(const LocalizeService& service) {
  const std::shared_ptr<const ServedMap> map = service.map();
  const MapSnapshot snapshot = map->store().Snapshot();
  const MapInfo info = snapshot.Info();
  const std::shared_ptr<const Codebook> codebook = snapshot.CurrentCodebook();
  const ServerOptions& options = service.options();
  const Json json = {
      {"name", "cairn"},
      {"version", CAIRN_VERSION},
      {"map",
       {{"version", Value(info.version)},
        {"created", info.created_at},
        {"sessions", info.num_sessions},
        {"keyframes", info.num_keyframes},
        {"tiles", info.num_tiles},
        {"landmarks", info.num_landmarks},
        {"descriptors", info.num_descriptors},
        {"payloadBytes", info.payload_bytes},
        {"bounds", BoundsJson(info.bounds)},
        {"descriptorType", codebook ? Json(codebook->descriptor_type) : Json(nullptr)},
        {"codec", codebook ? Json(codebook->CodecName()) : Json(nullptr)}}},
      {"limits",
       {{"bodyBytes", options.max_body_bytes},
        {"imagePixels", options.max_image_pixels},
        {"features", options.max_features},
        {"defaultTimeoutMs", options.default_timeout_ms}}}};
  return HttpResponse::Json(json.dump());
}

HttpResponse Redirect(const char* location) {
  return {.status = 302, .headers = {{"Location", location}}};
}

std::function<HttpResponse(const HttpRequest&)> Asset(std::string_view content,
                                                      const char* content_type) {
  return [body = FixedBody(content), content_type](const HttpRequest& request) {
    return body.AddTo(
        request, {.status = 200,
                  .content_type = content_type,
                  .headers = {{"Content-Security-Policy",
                               "default-src 'self'; img-src 'self' blob: data:; frame-ancestors "
                               "'none'"}}});
  };
}

}  // namespace cairn
