#include "http/handlers/localize_handlers.h"

#include <fmt/format.h>

#include <utility>

#include "http/json/geopose_protocol.h"
#include "http/json/localize_response.h"
#include "http/wire/problem.h"

namespace cairn {

namespace {

// For formats that can express nothing but a pose: throws HttpError kNotLocalized if there is none.
void RequirePose(const LocalizeResult& result, const char* hint) {
  if (result.localized) {
    return;
  }
  throw HttpError(ProblemCode::kNotLocalized,
                  fmt::format("no pose was found: {}", NotLocalizedReasonName(result.reason)))
      .Hint(hint);
}

HttpResponse OgcGeoPose(const LocalizeResult& result, const LocalizeRequest& query) {
  HttpResponse response = HttpResponse::Json(OgcGeoPoseJson(result, query));
  response.content_type = "application/geopose+json";
  return response;
}

}  // namespace

HttpResponse HandleLocalize(const HttpRequest& request, LocalizeService* service) {
  LocalizeRequest query;
  const LocalizeService::Answer answer = service->Localize(request, ParseLocalizeRequest, &query);
  if (WantsOgcGeoPose(request.Header("accept"))) {
    RequirePose(answer.result, "ask for application/json to get more details");
    return OgcGeoPose(answer.result, query);
  }
  return HttpResponse::Json(LocalizeResponseJson(answer.result, query, answer.times));
}

HttpResponse HandleGeoPose(const HttpRequest& request, LocalizeService* service) {
  LocalizeRequest query;
  const LocalizeService::Answer answer = service->Localize(request, ParseGeoPoseRequest, &query);
  RequirePose(answer.result, "use POST /v1/localize to get more details");
  if (WantsOgcGeoPose(request.Header("accept"))) {
    return OgcGeoPose(answer.result, query);
  }
  HttpResponse response = HttpResponse::Json(GeoPoseResponseJson(answer.result, query));
  response.content_type = GeoPoseContentType(request.Header("accept"));
  return response;
}

HttpResponse HandleGeoPoseStatus() { return HttpResponse::Json(R"({"status":"running"})"); }

}  // namespace cairn
