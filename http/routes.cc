#include "http/routes.h"

#include <string>
#include <utility>
#include <vector>

#include "http/handlers/localize_handlers.h"
#include "http/handlers/map_handlers.h"
#include "http/handlers/query_parameters.h"
#include "http/handlers/status_handlers.h"
#include "http/web_assets.h"

namespace cairn {
namespace {

using Id = std::string;

// The rights that open a route.
constexpr KeyRights kOpen;
constexpr KeyRights kQuery = KeyRight::kLocalize;
constexpr KeyRights kLook = KeyRight::kLook;
constexpr KeyRights kCopy = KeyRight::kCopy;
// Clients that localize ask whether and how they can.
constexpr KeyRights kQueryOrLook = KeyRight::kLocalize | KeyRight::kLook;

// Refuses requests with other query parameters, so that a misspelt one does not go unnoticed.
RouteHandler Taking(std::vector<std::string> parameters, RouteHandler handler) {
  return [known = std::move(parameters), handler = std::move(handler)](const HttpRequest& request,
                                                                       const Id& id) {
    RequireKnownParameters(request, known);
    return handler(request, id);
  };
}

void AddQueries(LocalizeService* service, Router* router) {
  router->Add(
      {"POST", "/v1/localize", kQuery, Taking({}, [=](const HttpRequest& request, const Id&) {
         return HandleLocalize(request, service);
       })});
  router->Add({"GET", "/v1/availability", kQueryOrLook,
               Taking({"lat", "lon", "accuracy"}, [=](const HttpRequest& request, const Id&) {
                 return HandleAvailability(request, *service);
               })});
  router->Add({"GET", "/geopose", kQueryOrLook,
               Taking({}, [](const HttpRequest&, const Id&) { return HandleGeoPoseStatus(); })});
  router->Add({"POST", "/geopose", kQuery, Taking({}, [=](const HttpRequest& request, const Id&) {
                 return HandleGeoPose(request, service);
               })});
  router->Add({"GET", "/version", kQueryOrLook,
               Taking({}, [=](const HttpRequest&, const Id&) { return HandleVersion(*service); })});
}

void AddMap(LocalizeService* service, Router* router) {
  const std::vector<std::string> page = {"bbox", "limit", "after"};
  router->Add(
      {"GET", "/v1/coverage", kLook, Taking(page, [=](const HttpRequest& request, const Id&) {
         return HandleCoverage(request, service);
       })});
  router->Add({"GET", "/v1/tiles", kLook, Taking(page, [=](const HttpRequest& request, const Id&) {
                 return HandleTiles(request, service);
               })});
  router->Add(
      {"GET", "/v1/versions", kLook, Taking({"limit"}, [=](const HttpRequest& request, const Id&) {
         return HandleVersions(request, service);
       })});
  router->Add(
      {"GET", "/v1/tiles/{id}", kLook, Taking({}, [=](const HttpRequest& request, const Id& id) {
         return HandleTile(request, id, *service);
       })});
  router->Add({"GET", "/v1/tiles/{id}/payload", kCopy,
               Taking({}, [=](const HttpRequest& request, const Id& id) {
                 return HandleTilePayload(request, id, service);
               })});
}

RouteHandler Page(std::string_view content, const char* content_type) {
  return [answer = Asset(content, content_type)](const HttpRequest& request, const Id&) {
    return answer(request);
  };
}

void AddPages(Router* router) {
  router->Add({"GET", "/openapi.json", kOpen, Page(http_web::k_openapi_json, "application/json")});
  router->Add({"GET", "/", kOpen, [](const HttpRequest&, const Id&) { return Redirect("ui"); }});
  router->Add(
      {"GET", "/ui/", kOpen, [](const HttpRequest&, const Id&) { return Redirect("../ui"); }});
  router->Add({"GET", "/ui", kOpen, Page(http_web::k_index_html, "text/html; charset=utf-8")});
  router->Add(
      {"GET", "/ui/app.js", kOpen, Page(http_web::k_app_js, "text/javascript; charset=utf-8")});
  router->Add(
      {"GET", "/ui/style.css", kOpen, Page(http_web::k_style_css, "text/css; charset=utf-8")});
}

void AddAdmin(LocalizeService* service, Router* router) {
  router->Add({"GET", "/healthz", kLook,
               [=](const HttpRequest&, const Id&) { return HandleHealth(*service); }});
  router->Add({"GET", "/livez", kOpen, [](const HttpRequest&, const Id&) { return HandleLive(); }});
  router->Add({"GET", "/readyz", kOpen,
               [=](const HttpRequest&, const Id&) { return HandleReady(*service); }});
  router->Add({"GET", "/metrics", kLook,
               [=](const HttpRequest&, const Id&) { return HandleMetrics(service); }});
}

}  // namespace

Router MainRoutes(LocalizeService* service, bool with_admin) {
  Router router;
  AddQueries(service, &router);
  AddMap(service, &router);
  AddPages(&router);
  if (with_admin) {
    AddAdmin(service, &router);
  }
  return router;
}

Router AdminRoutes(LocalizeService* service) {
  Router router;
  AddAdmin(service, &router);
  return router;
}

}  // namespace cairn
