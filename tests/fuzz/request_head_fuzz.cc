// The head of an HTTP request and its target.
#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "http/net/request_head.h"
#include "http/net/url.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kMaxBodyBytes = size_t{2} << 20;
  try {
    const cairn::RequestHead head =
        cairn::ParseRequestHead(cairn::testing::AsText(data, size), kMaxBodyBytes);
    CAIRN_CHECK(head.content_length <= kMaxBodyBytes, "a body beyond the limit");
    CAIRN_CHECK(head.headers.size() <= cairn::kMaxHeaders, "headers beyond the limit");
    cairn::ParseTarget(head.target);
  } catch (const cairn::Error&) {
  }
  return 0;
}
