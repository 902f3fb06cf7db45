// Bodies of type multipart/form-data (RFC 7578), split in place.
#ifndef CAIRN_HTTP_WIRE_MULTIPART_H_
#define CAIRN_HTTP_WIRE_MULTIPART_H_

#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Views of the body.
struct MultipartPart {
  std::string_view name;
  std::string_view content;
};

// True if the Content-Type is multipart/form-data.
bool IsMultipart(std::string_view content_type);

// Runs in time linear in the body. Throws HttpError kInvalidMultipart if the boundary is missing,
// if the framing is broken (for example, no closing boundary after the last part), if a part has no
// name, if two parts have the same name, or if there are more than 16 parts.
std::vector<MultipartPart> ParseMultipart(std::string_view content_type, std::string_view body);

// Writes a multipart body part by part.
class MultipartWriter {
 public:
  // The Content-Type of the whole body, with the boundary.
  static std::string ContentType();

  // `bytes` must not contain the boundary. The boundary is a random constant, so a collision is
  // practically impossible.
  void Add(std::string_view name, std::string_view content_type, std::string_view bytes);
  std::string Finish() &&;

 private:
  std::string body_;
};

// The media type of a Content-Type without its parameters, in lower case.
std::string MediaType(std::string_view content_type);

// The value of a parameter ("boundary", "name") without quotes; empty if the parameter is absent.
std::string_view HeaderParameter(std::string_view header_value, std::string_view parameter);

}  // namespace cairn

#endif  // CAIRN_HTTP_WIRE_MULTIPART_H_
