// Files of API keys, and the headers that present one.
#include "core/error.h"
#include "core/wire/problem.h"
#include "fuzz/fuzz_target.h"
#include "http/keys/key_file.h"
#include "http/keys/key_ring.h"
#include "http/keys/presented_key.h"

namespace cairn {
namespace {

// What is read is written and read again with the same outcome.
void TakeFile(std::string_view text) {
  try {
    const std::vector<ApiKey> keys = ParseKeys(text);
    const std::string written = KeysAsText(keys);
    CAIRN_CHECK(KeysAsText(ParseKeys(written)) == written, "what is written reads back");
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput, error.what());
  }
}

// No header opens a server whose only key has a hash that no text has.
void TakeHeader(std::string_view value) {
  static const KeyRing ring({{.label = "nobody", .hash = KeyHash{}, .may = KeyRight::kLocalize}});
  try {
    ring.Identify(PresentedKey({value}, {}));
    CAIRN_CHECK(false, "a header without the key was accepted");
  } catch (const HttpError& error) {
    CAIRN_CHECK(error.problem() == ProblemCode::kUnauthorized, error.what());
  }
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text = cairn::testing::AsText(data, size);
  cairn::TakeFile(text);
  cairn::TakeHeader(text);
  return 0;
}
