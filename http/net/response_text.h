// A response as bytes.
#ifndef CAIRN_HTTP_NET_RESPONSE_TEXT_H_
#define CAIRN_HTTP_NET_RESPONSE_TEXT_H_

#include <chrono>
#include <optional>
#include <string>

#include "http/net/message.h"

namespace cairn {

// Head and body are separate so that a body of megabytes is not copied.
struct ResponseText {
  std::string head;
  std::string body;
};

// `is_head` marks the response to HEAD, which has a Content-Length but no body. `keep_alive` is the
// time for which the connection stays open, stated in whole seconds; without it, the connection
// closes after the response.
ResponseText SerializeResponse(HttpResponse response, bool is_head,
                               std::optional<std::chrono::milliseconds> keep_alive);

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_RESPONSE_TEXT_H_
