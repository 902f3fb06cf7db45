// The bytes of a server, before the HTTP library of the clients sees them.
#include "fuzz/fuzz_target.h"
#include "http/exchange/response_guard.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kMaxBodyBytes = 1000;
  const std::string_view bytes = cairn::testing::AsText(data, size);
  cairn::ResponseGuard whole(kMaxBodyBytes), by_bytes(kMaxBodyBytes);
  const bool passes = whole.Take(bytes);
  size_t num_passed = 0;
  for (const char byte : bytes) {
    if (!by_bytes.Take({&byte, 1})) {
      break;
    }
    ++num_passed;
  }
  CAIRN_CHECK(passes == (num_passed == size), "the verdict depends on how the bytes arrive");
  CAIRN_CHECK(num_passed <= cairn::ResponseGuard::kMaxHead + kMaxBodyBytes,
              "bytes beyond the limit");
  return 0;
}
