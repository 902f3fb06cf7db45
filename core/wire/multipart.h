// Bodies of type multipart/form-data (RFC 7578), split in place.
#ifndef CAIRN_CORE_WIRE_MULTIPART_H_
#define CAIRN_CORE_WIRE_MULTIPART_H_

#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Views of the body.
struct MultipartPart {
  std::string_view name;
  std::string_view content;  // As sent.
  bool is_base64 = false;    // By its Content-Transfer-Encoding.
};

// True if the Content-Type is multipart/form-data.
bool IsMultipart(std::string_view content_type);

// Reads bodies as RFC 2046 defines them: text may stand before the first boundary and after the
// last one, and blanks behind a boundary. Beyond that, accepts the bodies of known clients: lines
// may end with LF alone if all do, and the closing boundary may be missing; the last part then ends
// with the body. Runs in time linear in the body. Throws HttpError kInvalidMultipart if there is no
// boundary or no part, if the headers of a part do not end, if a part has no name, if two parts
// have the same name, or if there are more than 16 parts.
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
// Escapes in quoted values stay as they are.
std::string_view HeaderParameter(std::string_view header_value, std::string_view parameter);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_MULTIPART_H_
