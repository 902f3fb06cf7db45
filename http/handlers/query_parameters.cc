#include "http/handlers/query_parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/printable.h"
#include "core/wire/problem.h"

namespace cairn {

void RequireKnownParameters(const HttpRequest& request, const std::vector<std::string>& known) {
  for (auto it = request.query.begin(); it != request.query.end();
       it = request.query.upper_bound(it->first)) {
    const std::string& name = it->first;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw HttpError(ProblemCode::kInvalidField,
                      fmt::format("this path has no query parameter '{}'", Excerpt(name)))
          .Hint(known.empty() ? "this path takes no query parameters"
                              : fmt::format("known: {}", fmt::join(known, ", ")));
    }
    if (request.query.count(name) > 1) {
      throw HttpError(ProblemCode::kInvalidField,
                      fmt::format("the query parameter '{}' is there twice", name));
    }
  }
}

}  // namespace cairn
