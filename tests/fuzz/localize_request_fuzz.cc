// The JSON of a request to /v1/localize and GeoPoseProtocol. It must be accepted or refused with
// an Error.
#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "http/json/geopose_protocol.h"
#include "http/json/localize_request.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text = cairn::testing::AsText(data, size);
  const cairn::RequestLimits limits;
  CAIRN_CHECK(cairn::PeekTimeoutMs(text, limits) > 0, "a timeout has to be positive");
  for (cairn::BodyParser* parse : {cairn::ParseLocalizeRequest, cairn::ParseGeoPoseRequest}) {
    try {
      const cairn::LocalizeRequest request = parse("application/json", text, limits);
      CAIRN_CHECK(request.timeout_ms > 0, "a request has a timeout");
    } catch (const cairn::Error&) {
    }
  }
  return 0;
}
