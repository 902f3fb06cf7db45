// Query lists of `cairn eval --queries`. Their feature files may be missing.
#include "core/error.h"
#include "eval/eval_query.h"
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  try {
    ReadQueryList(
        cairn::testing::WriteFuzzFile("queries.json", cairn::testing::AsText(data, size)));
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput || error.code() == ErrorCode::kNotFound,
                error.what());
  }
  return 0;
}
