// One table of all ways in which a request can fail, and the body of a failure on the wire (RFC
// 9457 problem details).
#ifndef CAIRN_CORE_WIRE_PROBLEM_H_
#define CAIRN_CORE_WIRE_PROBLEM_H_

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {

// The stable `code` of a problem. docs/http.md lists the codes for users.
enum class ProblemCode {
  // Faults of the HTTP message.
  kBadRequest,      // Not HTTP according to RFC 9112.
  kRequestTimeout,  // The request did not arrive in time.
  kLengthRequired,  // A body without Content-Length, or a chunked body.
  kPayloadTooLarge,
  kUriTooLong,
  kUnsupportedMediaType,
  kUnsupportedEncoding,  // Content-Encoding other than identity.
  kExpectationFailed,
  kHeadersTooLarge,
  kNotImplemented,  // A method that HTTP does not define.
  kVersionNotSupported,
  // Faults of the client's rights.
  kUnauthorized,     // The API key is missing or unknown.
  kForbidden,        // The key has not the right to this route.
  kTooManyRequests,  // The key has used up its rate or quota.
  // Faults of the route.
  kNotFound,
  kMethodNotAllowed,
  // Faults of the content.
  kInvalidJson,   // Does not parse, is nested too deeply, or is not UTF-8.
  kInvalidField,  // Parses, but a member is missing or invalid.
  kInvalidMultipart,
  kInvalidFeatures,  // The features blob does not decode.
  kWrongCodec,       // The features have the codec of another map.
  kTooManyFeatures,
  kInvalidImage,  // The image does not decode.
  kImageTooLarge,
  kNotLocalized,  // GeoPoseProtocol only: the protocol cannot express a miss.
  // Faults of the server.
  kBadInput,
  kMapDamaged,
  kIo,
  kInternal,
  kUnavailable,
};

struct ProblemInfo {
  ProblemCode code;
  int status;
  const char* name;  // On the wire.
  const char* title;
};

// All problems, in the order of the enumeration.
std::span<const ProblemInfo> AllProblems();
const ProblemInfo& InfoOf(ProblemCode code);

// Maps the project's errors to problems. No other code does.
ProblemCode ProblemFromErrorCode(ErrorCode code);

// A failed request. `what()` is the detail, written for the client's developer. Detail, pointer and
// hint are cut after 1,000 bytes.
class HttpError : public Error {
 public:
  HttpError(ProblemCode code, const std::string& detail);

  // Sets the member at fault, as a JSON pointer (RFC 6901) into the request's JSON.
  HttpError&& At(std::string pointer) &&;
  // Sets the advice on how to mend the request.
  HttpError&& Hint(std::string hint) &&;
  HttpError&& Header(std::string name, std::string value) &&;

  ProblemCode problem() const { return problem_; }
  const std::string& pointer() const { return pointer_; }
  bool has_pointer() const { return has_pointer_; }
  const std::string& hint() const { return hint_; }
  const std::vector<std::pair<std::string, std::string>>& headers() const { return headers_; }

 private:
  ProblemCode problem_;
  bool has_pointer_ = false;
  std::string pointer_;
  std::string hint_;
  std::vector<std::pair<std::string, std::string>> headers_;
};

// Converts an Error for the client. An HttpError passes unchanged. A JsonError is of the request:
// it becomes kInvalidJson, or kInvalidField with its pointer. Of other errors, messages about the
// request (kBadInput, kInvalidArgument) pass unchanged. All other messages concern the server's own
// files and state. A reference to the server's log replaces them, so that no file path leaves the
// server.
HttpError PublicError(const Error& error);

// The application/problem+json body. Bytes that are not UTF-8 are replaced.
std::string ProblemJson(const HttpError& error, const std::string& request_id);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_PROBLEM_H_
