// The query of a request's target: "?limit=10&bbox=1,2,3,4".
#ifndef CAIRN_HTTP_HANDLERS_QUERY_PARAMETERS_H_
#define CAIRN_HTTP_HANDLERS_QUERY_PARAMETERS_H_

#include <string>
#include <vector>

#include "http/net/message.h"

namespace cairn {

// Throws HttpError kInvalidField, which names the parameter, if the request has a parameter that is
// not among `known`, or one of them twice.
void RequireKnownParameters(const HttpRequest& request, const std::vector<std::string>& known);

}  // namespace cairn

#endif  // CAIRN_HTTP_HANDLERS_QUERY_PARAMETERS_H_
