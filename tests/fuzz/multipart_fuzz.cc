// A multipart body with the boundary B, which is split and read as a request.
#include "core/error.h"
#include "core/wire/multipart.h"
#include "fuzz/fuzz_target.h"
#include "http/json/localize_request.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr std::string_view kType = "multipart/form-data; boundary=B";
  const std::string_view body = cairn::testing::AsText(data, size);
  try {
    for (const cairn::MultipartPart& part : cairn::ParseMultipart(kType, body)) {
      CAIRN_CHECK(part.content.data() >= body.data() &&
                      part.content.data() + part.content.size() <= body.data() + body.size(),
                  "a part lies outside of the body");
    }
    cairn::ParseLocalizeRequest(kType, body, cairn::RequestLimits());
  } catch (const cairn::Error&) {
  }
  return 0;
}
