#include "http/handlers/localize_handlers.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "core/cell_name.h"
#include "core/wire/problem.h"
#include "http/json/geopose_protocol.h"
#include "http/json/localize_response.h"
#include "http/json/request_photos.h"

namespace cairn {

namespace {

// For formats that can express nothing but a pose: throws HttpError kNotLocalized if there is none.
void RequirePose(const LocalizeResult& result, const char* hint) {
  if (result.localized) {
    return;
  }
  throw HttpError(ProblemCode::kNotLocalized,
                  fmt::format("no pose was found: {}: {}", NotLocalizedReasonName(result.reason),
                              result.reason_text))
      .Header(kReasonHeader, NotLocalizedReasonName(result.reason))
      .Hint(hint);
}

HttpResponse OgcGeoPose(const LocalizeResult& result, const LocalizeRequest& query) {
  HttpResponse response = HttpResponse::Json(OgcGeoPoseJson(result, query));
  response.content_type = "application/geopose+json";
  return response;
}

// Says where the prior came from.
HttpResponse WithPriorSource(HttpResponse response, const LocalizeQuery& query) {
  if (query.prior) {
    response.headers.emplace_back(kPriorHeader, PriorSourceName(query.prior->source));
  }
  return response;
}

// Says why there is no pose, also to fronts and logs that do not read the body.
HttpResponse WithReason(HttpResponse response, const LocalizeResult& result) {
  if (!result.localized) {
    response.headers.emplace_back(kReasonHeader, NotLocalizedReasonName(result.reason));
  }
  return response;
}

// Names the cell of the pose, or else of the prior, so that the client can send the name with its
// next query.
HttpResponse WithCell(HttpResponse response, const LocalizeResult& result,
                      const LocalizeQuery& query) {
  if (result.localized) {
    response.headers.emplace_back(kCellHeader, CellName(result.position));
  } else if (query.prior) {
    response.headers.emplace_back(kCellHeader, CellName(query.prior->position));
  }
  return response;
}

// Adds what the headers say of every answer.
HttpResponse WithHeaders(HttpResponse response, const LocalizeResult& result,
                         const LocalizeQuery& query) {
  return WithPriorSource(WithCell(WithReason(std::move(response), result), result, query), query);
}

// The response to POST /v1/localize without its headers.
HttpResponse LocalizeResponse(const LocalizeService::Answer& answer, const std::string& accept) {
  if (WantsOgcGeoPose(accept)) {
    RequirePose(answer.result, "ask for application/json to get more details");
    return OgcGeoPose(answer.result, answer.request);
  }
  return HttpResponse::Json(LocalizeResponseJson(answer.result, answer.request, answer.times));
}

HttpResponse GeoPoseResponse(const LocalizeService::Answer& answer, const std::string& accept) {
  RequirePose(answer.result, "use POST /v1/localize to get more details");
  if (WantsOgcGeoPose(accept)) {
    return OgcGeoPose(answer.result, answer.request);
  }
  HttpResponse response = HttpResponse::Json(GeoPoseResponseJson(answer.result, answer.request));
  response.content_type = GeoPoseContentType(accept);
  return response;
}

// A body is parsed unless its turn has not come in time.
LocalizeService::Answer AnswerQuery(const HttpRequest& request, BodyParser& parse,
                                    LocalizeService* service) {
  LocalizeService::Visit visit = service->Receive(request);
  if (visit.is_late()) {
    return service->AnswerLate(visit);
  }
  return service->Localize(std::move(visit), parse(request.Header("content-type"), request.body,
                                                   service->request_limits()));
}

}  // namespace

HttpResponse HandleLocalize(const HttpRequest& request, LocalizeService* service) {
  const LocalizeService::Answer answer = AnswerQuery(request, ParseLocalizeRequest, service);
  return WithHeaders(LocalizeResponse(answer, request.Header("accept")), answer.result,
                     answer.request.query);
}

HttpResponse HandleGeoPose(const HttpRequest& request, LocalizeService* service) {
  const LocalizeService::Answer answer = AnswerQuery(request, ParseGeoPoseRequest, service);
  return WithHeaders(GeoPoseResponse(answer, request.Header("accept")), answer.result,
                     answer.request.query);
}

HttpResponse HandleGeoPoseStatus() { return HttpResponse::Json(R"({"status":"running"})"); }

}  // namespace cairn
