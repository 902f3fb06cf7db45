#include "core/wire/problem.h"

#include <array>
#include <nlohmann/json.hpp>

#include "core/check.h"
#include "core/printable.h"
#include "core/wire/json_error.h"

namespace cairn {
namespace {

using enum ProblemCode;

constexpr std::array kProblems = {
    ProblemInfo{kBadRequest, 400, "bad_request", "Malformed HTTP request"},
    ProblemInfo{kRequestTimeout, 408, "request_timeout", "The request did not arrive in time"},
    ProblemInfo{kLengthRequired, 411, "length_required", "Content-Length required"},
    ProblemInfo{kPayloadTooLarge, 413, "payload_too_large", "The body is too large"},
    ProblemInfo{kUriTooLong, 414, "uri_too_long", "The request target is too long"},
    ProblemInfo{kUnsupportedMediaType, 415, "unsupported_media_type", "Unsupported content type"},
    ProblemInfo{kUnsupportedEncoding, 415, "unsupported_encoding", "Unsupported content encoding"},
    ProblemInfo{kExpectationFailed, 417, "expectation_failed", "Unknown expectation"},
    ProblemInfo{kHeadersTooLarge, 431, "headers_too_large", "The header is too large"},
    ProblemInfo{kNotImplemented, 501, "not_implemented", "Unknown method"},
    ProblemInfo{kVersionNotSupported, 505, "version_not_supported", "Unsupported HTTP version"},
    ProblemInfo{kUnauthorized, 401, "unauthorized", "An API key is needed"},
    ProblemInfo{kForbidden, 403, "forbidden", "The API key does not allow this"},
    ProblemInfo{kTooManyRequests, 429, "too_many_requests", "Too many requests"},
    ProblemInfo{kNotFound, 404, "not_found", "Not found"},
    ProblemInfo{kMethodNotAllowed, 405, "method_not_allowed", "Method not allowed"},
    ProblemInfo{kInvalidJson, 400, "invalid_json", "The body is not usable JSON"},
    ProblemInfo{kInvalidField, 400, "invalid_field", "A member of the request is invalid"},
    ProblemInfo{kInvalidMultipart, 400, "invalid_multipart", "The multipart body is malformed"},
    ProblemInfo{kInvalidFeatures, 400, "invalid_features", "The features do not decode"},
    ProblemInfo{kWrongCodec, 409, "wrong_codec", "The features do not have this map's codec"},
    ProblemInfo{kTooManyFeatures, 413, "too_many_features", "Too many features"},
    ProblemInfo{kInvalidImage, 400, "invalid_image", "The image does not decode"},
    ProblemInfo{kImageTooLarge, 413, "image_too_large", "The image has too many pixels"},
    ProblemInfo{kNotLocalized, 404, "not_localized", "No pose was found"},
    ProblemInfo{kBadInput, 400, "bad_input", "The request cannot be used"},
    ProblemInfo{kMapDamaged, 500, "map_damaged", "The map is damaged"},
    ProblemInfo{kIo, 500, "io", "The server could not read or write"},
    ProblemInfo{kInternal, 500, "internal", "Internal error"},
    ProblemInfo{kUnavailable, 503, "unavailable", "Not available now"},
};

// Bounds the response: a name in the request may have megabytes.
std::string Cut(const std::string& text) {
  constexpr size_t kMaxBytes = 1000;
  return text.size() <= kMaxBytes ? text : Excerpt(text, kMaxBytes);
}

// The project error of a problem, for callers that only know Error.
ErrorCode ErrorCodeOf(ProblemCode problem) {
  switch (problem) {
    case kNotFound:
    case kNotLocalized:
      return ErrorCode::kNotFound;
    case kWrongCodec:
      return ErrorCode::kConflict;
    case kMapDamaged:
      return ErrorCode::kMapDamaged;
    case kIo:
      return ErrorCode::kIo;
    case kInternal:
      return ErrorCode::kInternal;
    case kUnavailable:
    case kTooManyRequests:
      return ErrorCode::kUnavailable;
    default:
      return ErrorCode::kBadInput;
  }
}

}  // namespace

std::span<const ProblemInfo> AllProblems() { return kProblems; }

const ProblemInfo& InfoOf(ProblemCode code) {
  const ProblemInfo& info = kProblems.at(static_cast<size_t>(code));
  CAIRN_CHECK(info.code == code, "the problem table is not in the order of the enumeration");
  return info;
}

ProblemCode ProblemFromErrorCode(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
    case ErrorCode::kBadInput:
      return kBadInput;
    case ErrorCode::kMapDamaged:
      return kMapDamaged;
    case ErrorCode::kIo:
      return kIo;
    case ErrorCode::kConflict:  // Another program holds the map.
    case ErrorCode::kUnavailable:
      return kUnavailable;
    case ErrorCode::kNotFound:  // A missing file. Routes that find nothing throw HttpError.
    case ErrorCode::kInternal:
      break;
  }
  return kInternal;
}

HttpError::HttpError(ProblemCode code, const std::string& detail)
    : Error(ErrorCodeOf(code), Cut(detail)), problem_(code) {}

HttpError&& HttpError::At(std::string pointer) && {
  pointer_ = Cut(pointer);
  has_pointer_ = true;
  return std::move(*this);
}

HttpError&& HttpError::Hint(std::string hint) && {
  hint_ = Cut(hint);
  return std::move(*this);
}

HttpError&& HttpError::Header(std::string name, std::string value) && {
  headers_.emplace_back(std::move(name), std::move(value));
  return std::move(*this);
}

HttpError PublicError(const Error& error) {
  if (const auto* refusal = dynamic_cast<const HttpError*>(&error)) {
    return *refusal;
  }
  if (const auto* json = dynamic_cast<const JsonError*>(&error)) {
    return json->pointer()
               ? HttpError(kInvalidField, json->what()).At(*json->pointer()).Hint(json->hint())
               : HttpError(kInvalidJson, json->what()).Hint(json->hint());
  }
  const ProblemCode code = ProblemFromErrorCode(error.code());
  if (InfoOf(code).status < 500) {
    return HttpError(code, error.what());
  }
  return HttpError(code, "the server failed; its log has the cause under this request id");
}

std::string ProblemJson(const HttpError& error, const std::string& request_id) {
  const ProblemInfo& info = InfoOf(error.problem());
  nlohmann::ordered_json body = {
      {"type", std::string("urn:cairn:problem:") + info.name},
      {"title", info.title},
      {"status", info.status},
      {"detail", error.what()},
      {"code", info.name},
  };
  if (error.has_pointer()) {
    body["errors"] = {{{"pointer", error.pointer()}, {"detail", error.what()}}};
  }
  if (!error.hint().empty()) {
    body["hint"] = error.hint();
  }
  body["requestId"] = request_id;
  return body.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace cairn
