#include "http/dispatcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <new>
#include <optional>
#include <string_view>

#include "core/cell_name.h"
#include "core/logging.h"
#include "core/wire/json_error.h"
#include "http/json/request_photos.h"
#include "http/keys/presented_key.h"
#include "http/net/url.h"

namespace cairn {
namespace {

HttpResponse ProblemResponse(const HttpError& error, const std::string& request_id) {
  HttpResponse response = {.status = InfoOf(error.problem()).status,
                           .content_type = "application/problem+json",
                           .body = ProblemJson(error, request_id),
                           .headers = error.headers()};
  if (error.problem() == ProblemCode::kUnavailable) {
    response.headers.emplace_back("Retry-After", "1");
  }
  return response;
}

// Pages of any origin may use the API (WebXR clients do). A browser sends no key of its own accord:
// the page has to know it.
void AddCommonHeaders(const std::string& request_id, HttpResponse* response) {
  response->headers.emplace_back("X-Request-Id", request_id);
  response->headers.emplace_back("X-Content-Type-Options", "nosniff");
  response->headers.emplace_back("Access-Control-Allow-Origin", "*");
  response->headers.emplace_back(
      "Access-Control-Expose-Headers",
      fmt::format("ETag, Retry-After, WWW-Authenticate, X-Request-Id, {}, {}, {}", kCellHeader,
                  kPriorHeader, kReasonHeader));
}

// Why there is no pose, or the code of a refusal.
std::string_view ReasonOf(const HttpResponse& response, const char* problem) {
  const auto found = std::find_if(response.headers.begin(), response.headers.end(),
                                  [](const auto& header) { return header.first == kReasonHeader; });
  return found == response.headers.end() ? problem : std::string_view(found->second);
}

// True for a list of header names, as a browser writes it.
bool IsListOfNames(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("!#$%&'*+-.^_`|~, ").find(c) != std::string_view::npos;
  });
}

// Allows whatever headers the page wants to send. The server ignores the headers that it does not
// know, but proxies and tunnels on the way need theirs: Authorization, ngrok-skip-browser-warning.
HttpResponse PreflightResponse(const std::string& allow, const HttpRequest& request) {
  const std::string& wanted = request.Header("access-control-request-headers");
  return {.status = 204,
          .content_type = "",
          .body = "",
          .headers = {
              {"Allow", allow},
              {"Access-Control-Allow-Methods", allow},
              {"Access-Control-Allow-Headers",
               IsListOfNames(wanted)
                   ? wanted
                   : fmt::format("Accept, Authorization, Content-Type, If-None-Match, X-API-Key, "
                                 "X-Request-Id, {}",
                                 kCellHeader)},
              {"Access-Control-Max-Age", "86400"},
              {"Vary", "Access-Control-Request-Headers"}}};
}

// For an instant of a moment ago.
KeyRing::Now TimeOfUse(std::chrono::steady_clock::time_point steady) {
  const auto unix_time = std::chrono::system_clock::now().time_since_epoch();
  return {.steady = steady,
          .unix_s = std::chrono::duration_cast<std::chrono::seconds>(unix_time).count()};
}

}  // namespace

void Dispatcher::LogFailure(const HttpRequest& request, const std::string& route_pattern,
                            const char* what) const {
  const std::optional<int64_t> num_left_out = failures_.Admit();
  if (!num_left_out) {
    return;
  }
  LogError("{} {}: {} [{}]{}", request.method, route_pattern, what, request.request_id,
           *num_left_out == 0
               ? ""
               : fmt::format(" ({} failures before were not logged)", *num_left_out));
}

void Dispatcher::Admit(const Route& route, HttpRequest* request) const {
  if (keys_ == nullptr || route.needs.empty()) {
    return;
  }
  const KeyRing::Holder holder = keys_->Identify(PresentedKey(request->headers));
  request->label = holder.key.label;
  request->client = holder.client;
  KeyRing::RequireRight(holder, route.needs);
  keys_->Charge(holder, TimeOfUse(request->arrival));
}

void Dispatcher::CheckHead(const RequestHead& head) {
  if (keys_ == nullptr || head.content_length == 0) {
    return;
  }
  const std::optional<Target> target = ParseTarget(head.target);
  if (!target) {
    throw HttpError(ProblemCode::kBadRequest, "the target has a malformed percent escape");
  }
  const Router::Match match = router_.Find(head.method, target->path);
  if (match.route == nullptr || match.route->needs.empty()) {
    throw HttpError(ProblemCode::kPayloadTooLarge, "this route takes no body");
  }
  const KeyRing::Holder holder = keys_->Identify(PresentedKey(head.headers));
  KeyRing::RequireRight(holder, match.route->needs);
  keys_->CheckUse(holder, TimeOfUse(std::chrono::steady_clock::now()));
}

HttpResponse Dispatcher::Run(HttpRequest* sent, Outcome* outcome) const {
  const HttpRequest& request = *sent;
  const auto refuse = [&](const HttpError& error) {
    outcome->problem = InfoOf(error.problem()).name;
    return ProblemResponse(error, request.request_id);
  };
  try {
    const Router::Match match = router_.Find(request.method, request.path);
    if (match.route == nullptr) {
      return PreflightResponse(match.allow, request);
    }
    outcome->route_pattern = match.route->pattern;
    Admit(*match.route, sent);
    return match.route->handler(request, match.path_parameter);
  } catch (const HttpError& e) {
    return refuse(e);
  } catch (const JsonError& e) {
    return refuse(PublicError(e));
  } catch (const Error& e) {
    metrics_->CountError(e.code());
    const HttpError shown = PublicError(e);
    if (InfoOf(shown.problem()).status >= 500) {
      LogFailure(request, outcome->route_pattern, e.what());
    }
    return refuse(shown);
  } catch (const std::bad_alloc&) {
    throw;  // The listener's response needs no memory.
  } catch (const std::exception& e) {
    LogFailure(request, outcome->route_pattern, e.what());
    return refuse(PublicError(Error(ErrorCode::kInternal, e.what())));
  }
}

HttpResponse Dispatcher::Handle(HttpRequest request) {
  Outcome outcome;
  HttpResponse response = Run(&request, &outcome);
  AddCommonHeaders(request.request_id, &response);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - request.arrival;
  metrics_->CountRequest(outcome.route_pattern, response.status, seconds.count());
  if (!request.label.empty()) {
    metrics_->CountClient(request.label, response.status);
  }
  if (access_log_ != nullptr) {
    access_log_->Add({.time = std::chrono::system_clock::now(),
                      .client = request.remote_address,
                      .label = request.label,
                      .method = request.method,
                      .path = request.path,
                      .status = response.status,
                      .num_bytes = request.method == "HEAD" ? 0 : response.body.size(),
                      .seconds = seconds.count(),
                      .reason = ReasonOf(response, outcome.problem),
                      .request_id = request.request_id});
  }
  LogDebug("{} {} {} {} {:.1f} ms [{}]", request.remote_address, request.method, request.path,
           response.status, 1e3 * seconds.count(), request.request_id);
  return response;
}

std::string Dispatcher::LabelOf(const HttpError& error, const RefusedRequest& request) const {
  if (keys_ == nullptr || (error.problem() != ProblemCode::kForbidden &&
                           error.problem() != ProblemCode::kTooManyRequests)) {
    return "";
  }
  try {
    return keys_->Identify(PresentedKey(request.headers)).key.label;
  } catch (const HttpError&) {
    return "";  // The key has been removed since.
  }
}

HttpResponse Dispatcher::Refuse(const HttpError& error, const RefusedRequest& request) {
  HttpResponse response = ProblemResponse(error, request.request_id);
  AddCommonHeaders(request.request_id, &response);
  metrics_->CountRequest("", response.status, 0.0);
  const std::string label = LabelOf(error, request);
  if (!label.empty()) {
    metrics_->CountClient(label, response.status);
  }
  if (access_log_ != nullptr) {
    const std::string_view target = request.target;
    access_log_->Add({.time = std::chrono::system_clock::now(),
                      .client = request.remote_address,
                      .label = label,
                      .method = request.method,
                      .path = target.substr(0, target.find('?')),
                      .status = response.status,
                      .num_bytes = response.body.size(),
                      .seconds = 0.0,
                      .reason = InfoOf(error.problem()).name,
                      .request_id = request.request_id});
  }
  return response;
}

}  // namespace cairn
