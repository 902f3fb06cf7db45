// Saves transfers of large responses.
#ifndef CAIRN_HTTP_HANDLERS_COMPACT_RESPONSE_H_
#define CAIRN_HTTP_HANDLERS_COMPACT_RESPONSE_H_

#include <string>
#include <string_view>

#include "http/net/message.h"

namespace cairn {

// True if the client has the contents of this entity tag already (If-None-Match).
bool IsUnchanged(const HttpRequest& request, std::string_view tag);

// Adds the entity tag and asks caches to compare it each time.
HttpResponse WithTag(HttpResponse response, const std::string& tag);

// Adds an entity tag made from the body. Returns 304 without a body if the client has the body
// already. Compresses a body of more than one packet if the client accepts gzip.
HttpResponse Compact(const HttpRequest& request, HttpResponse response);

// A body that all requests get. It is tagged and compressed once, not for each request.
class FixedBody {
 public:
  explicit FixedBody(std::string_view body);

  // As Compact: `response` with this body.
  HttpResponse AddTo(const HttpRequest& request, HttpResponse response) const;

 private:
  std::string plain_, zipped_, tag_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_HANDLERS_COMPACT_RESPONSE_H_
