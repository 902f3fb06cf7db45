// Base64 in requests: decoded data must encode to the same text.
#include "core/wire/base64.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text = cairn::testing::AsText(data, size);
  if (const auto bytes = cairn::DecodeBase64(text)) {
    CAIRN_CHECK(cairn::EncodeBase64(*bytes) == text, "decoding is not the inverse of encoding");
  }
  return 0;
}
