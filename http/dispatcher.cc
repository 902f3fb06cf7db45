#include "http/dispatcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <new>
#include <optional>
#include <string_view>

#include "core/cell_name.h"
#include "core/logging.h"
#include "http/json/request_photos.h"

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

// The API carries no credentials, so pages of any origin may use it (WebXR clients do).
void AddCommonHeaders(const std::string& request_id, HttpResponse* response) {
  response->headers.emplace_back("X-Request-Id", request_id);
  response->headers.emplace_back("X-Content-Type-Options", "nosniff");
  response->headers.emplace_back("Access-Control-Allow-Origin", "*");
  response->headers.emplace_back(
      "Access-Control-Expose-Headers",
      fmt::format("ETag, X-Request-Id, {}, {}", kCellHeader, kPriorHeader));
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
  return {
      .status = 204,
      .content_type = "",
      .body = "",
      .headers = {
          {"Allow", allow},
          {"Access-Control-Allow-Methods", allow},
          {"Access-Control-Allow-Headers",
           IsListOfNames(wanted)
               ? wanted
               : fmt::format("Accept, Authorization, Content-Type, If-None-Match, X-Request-Id, {}",
                             kCellHeader)},
          {"Access-Control-Max-Age", "86400"},
          {"Vary", "Access-Control-Request-Headers"}}};
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

HttpResponse Dispatcher::Run(const HttpRequest& request, std::string* route_pattern) const {
  try {
    const Router::Match match = router_.Find(request);
    if (match.route == nullptr) {
      return PreflightResponse(match.allow, request);
    }
    *route_pattern = match.route->pattern;
    return match.route->handler(request, match.path_parameter);
  } catch (const HttpError& e) {
    return ProblemResponse(e, request.request_id);
  } catch (const Error& e) {
    metrics_->CountError(e.code());
    const HttpError shown = PublicError(e);
    if (InfoOf(shown.problem()).status >= 500) {
      LogFailure(request, *route_pattern, e.what());
    }
    return ProblemResponse(shown, request.request_id);
  } catch (const std::bad_alloc&) {
    throw;  // The listener's response needs no memory.
  } catch (const std::exception& e) {
    LogFailure(request, *route_pattern, e.what());
    return ProblemResponse(PublicError(Error(ErrorCode::kInternal, e.what())), request.request_id);
  }
}

HttpResponse Dispatcher::Handle(const HttpRequest& request) {
  std::string route_pattern;
  HttpResponse response = Run(request, &route_pattern);
  AddCommonHeaders(request.request_id, &response);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - request.arrival;
  metrics_->CountRequest(route_pattern, response.status, seconds.count());
  LogDebug("{} {} {} {} {:.1f} ms [{}]", request.remote_address, request.method, request.path,
           response.status, 1e3 * seconds.count(), request.request_id);
  return response;
}

HttpResponse Dispatcher::Refuse(const HttpError& error, const std::string& request_id) {
  HttpResponse response = ProblemResponse(error, request_id);
  AddCommonHeaders(request_id, &response);
  metrics_->CountRequest("", response.status, 0.0);
  return response;
}

}  // namespace cairn
