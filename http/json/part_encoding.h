// Parts of a multipart body whose bytes are text.
#ifndef CAIRN_HTTP_JSON_PART_ENCODING_H_
#define CAIRN_HTTP_JSON_PART_ENCODING_H_

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/wire/multipart.h"

namespace cairn {

// Replaces the content of each part that says it is base64 by its bytes, which `bytes` then holds.
// Throws HttpError kInvalidMultipart, which names the part, if the text is not base64.
void DecodeParts(std::vector<MultipartPart>* parts, std::vector<std::vector<uint8_t>>* bytes);

// Throws HttpError kInvalidImage if a part with an image holds base64 text or a data: URL.
void RefuseImageAsText(std::string_view content, std::string_view part_name);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_PART_ENCODING_H_
