#include "http/handlers/localize_handlers.h"

#include <fmt/format.h>

#include <utility>

#include "http/json/geopose_protocol.h"
#include "http/json/localize_response.h"
#include "http/problem.h"

namespace cairn {

HttpResponse HandleLocalize(const HttpRequest& request, LocalizeService* service) {
  LocalizeRequest query;
  const LocalizeService::Answer answer = service->Localize(request, ParseLocalizeRequest, &query);
  return HttpResponse::Json(LocalizeResponseJson(answer.result, query, answer.times));
}

HttpResponse HandleGeoPose(const HttpRequest& request, LocalizeService* service) {
  LocalizeRequest query;
  const LocalizeService::Answer answer = service->Localize(request, ParseGeoPoseRequest, &query);
  if (!answer.result.localized) {
    throw HttpError(
        ProblemCode::kNotLocalized,
        fmt::format("no pose was found: {}", NotLocalizedReasonName(answer.result.reason)))
        .Hint("POST /v1/localize tells more about a miss");
  }
  HttpResponse response = HttpResponse::Json(GeoPoseResponseJson(answer.result, query));
  response.content_type = GeoPoseContentType(request.Header("accept"));
  return response;
}

HttpResponse HandleGeoPoseStatus() { return HttpResponse::Json(R"({"status":"running"})"); }

}  // namespace cairn
