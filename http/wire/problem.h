// Every way a request can fail, in one table, and its body on the wire (RFC 9457 problem details).
#ifndef CAIRN_HTTP_WIRE_PROBLEM_H_
#define CAIRN_HTTP_WIRE_PROBLEM_H_

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {

// The stable `code` of a problem; docs/http.md lists them for users.
enum class ProblemCode {
  // The message itself.
  kBadRequest,      // Not HTTP as RFC 9112 wants it.
  kRequestTimeout,  // The request did not arrive in time.
  kLengthRequired,  // A body without Content-Length, or chunked.
  kPayloadTooLarge,
  kUriTooLong,
  kUnsupportedMediaType,
  kUnsupportedEncoding,  // Content-Encoding other than identity.
  kExpectationFailed,
  kHeadersTooLarge,
  kNotImplemented,  // A method HTTP does not know.
  kVersionNotSupported,
  // The route.
  kNotFound,
  kMethodNotAllowed,
  // What it says.
  kInvalidJson,   // Does not parse, is too deep, or is not UTF-8.
  kInvalidField,  // Parses, but a member is missing or makes no sense.
  kInvalidMultipart,
  kInvalidFeatures,  // The features blob does not decode.
  kWrongCodec,       // Features of another map's codec.
  kTooManyFeatures,
  kInvalidImage,  // Does not decode.
  kImageTooLarge,
  kNotLocalized,  // GeoPoseProtocol only, which has no word for a miss.
  // The server.
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

// The one mapping from the project's errors to problems.
ProblemCode ProblemFromErrorCode(ErrorCode code);

// A failed request. `what()` is the detail, for the client's developer. Detail, pointer and hint
// are cut after 1,000 bytes.
class HttpError : public Error {
 public:
  HttpError(ProblemCode code, const std::string& detail);

  // The request member at fault, as a JSON pointer (RFC 6901) into the request's JSON.
  HttpError&& At(std::string pointer) &&;
  // What to do about it.
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

// An Error as the client may see it: messages about the request (kBadInput, kInvalidArgument) pass,
// all others are about the server's own files and state and are replaced by a reference to its log,
// so that no path of a file leaves the server.
HttpError PublicError(const Error& error);

// The application/problem+json body. Bytes that are not UTF-8 are replaced.
std::string ProblemJson(const HttpError& error, const std::string& request_id);

}  // namespace cairn

#endif  // CAIRN_HTTP_WIRE_PROBLEM_H_
