// Responses that a client reads from an untrusted server.
#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "http/json/localize_response.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    cairn::ParseLocalizeResponse(cairn::testing::AsText(data, size));
  } catch (const cairn::Error&) {
  }
  return 0;
}
