// Bodies of type multipart/form-data (RFC 7578), split in place.
#ifndef CAIRN_HTTP_WIRE_MULTIPART_H_
#define CAIRN_HTTP_WIRE_MULTIPART_H_

#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Views into the body.
struct MultipartPart {
  std::string_view name;
  std::string_view content;
};

// True if the Content-Type is multipart/form-data.
bool IsMultipart(std::string_view content_type);

// Linear in the body. Throws HttpError kInvalidMultipart if the boundary is missing, the framing is
// broken (also: the last part has no closing boundary), a part has no name, a name comes twice, or
// there are more than 16 parts.
std::vector<MultipartPart> ParseMultipart(std::string_view content_type, std::string_view body);

// Writes such a body part by part.
class MultipartWriter {
 public:
  // Of the whole body; has the boundary.
  static std::string ContentType();

  // The bytes may be anything but the boundary, whose randomness makes that certain enough.
  void Add(std::string_view name, std::string_view content_type, std::string_view bytes);
  std::string Finish() &&;

 private:
  std::string body_;
};

// The media type of a Content-Type without its parameters, in lower case.
std::string MediaType(std::string_view content_type);

// The value of a parameter ("boundary", "name"), without quotes; empty if it is not there.
std::string_view HeaderParameter(std::string_view header_value, std::string_view parameter);

}  // namespace cairn

#endif  // CAIRN_HTTP_WIRE_MULTIPART_H_
