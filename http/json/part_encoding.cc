#include "http/json/part_encoding.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/wire/base64.h"
#include "core/wire/problem.h"

namespace cairn {

void DecodeParts(std::vector<MultipartPart>* parts, std::vector<std::vector<uint8_t>>* bytes) {
  for (MultipartPart& part : *parts) {
    if (!part.is_base64) {
      continue;
    }
    std::optional<std::vector<uint8_t>> decoded = DecodeBase64OfClient(part.content);
    if (!decoded) {
      throw HttpError(ProblemCode::kInvalidMultipart,
                      fmt::format("the part '{}' states Content-Transfer-Encoding: base64, and its "
                                  "content is not base64",
                                  part.name.substr(0, 64)))
          .Hint("send the raw bytes without that header");
    }
    // Vectors keep their bytes when the outer vector moves them.
    const std::vector<uint8_t>& kept = bytes->emplace_back(std::move(*decoded));
    part.content = {reinterpret_cast<const char*>(kept.data()), kept.size()};
  }
}

void RefuseImageAsText(std::string_view content, std::string_view part_name) {
  content.remove_prefix(std::min(content.find_first_not_of(" \t\r\n\""), content.size()));
  const bool is_url = content.starts_with("data:");
  // The first bytes of JPEG and PNG in base64.
  if (is_url || content.starts_with("/9j/") || content.starts_with("iVBORw0KGgo")) {
    throw HttpError(ProblemCode::kInvalidImage,
                    fmt::format("the image in the part '{}' is {}", part_name,
                                is_url ? "a data: URL" : "base64 text"))
        .At(fmt::format("/{}", part_name))
        .Hint("send the raw bytes of the file");
  }
}

}  // namespace cairn
