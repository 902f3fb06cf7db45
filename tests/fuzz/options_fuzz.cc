// The files of --options: refused, or read and then written and read again with the same outcome.
#include "cli/options/read_options.h"
#include "cli/options/write_options.h"
#include "core/error.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  CairnOptions options;
  try {
    ReadOptions(cairn::testing::AsText(data, size), &options);
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput || error.code() == ErrorCode::kInvalidArgument,
                error.what());
    return 0;
  }
  const std::string json = OptionsAsJson(options);
  CairnOptions again;
  ReadOptions(json, &again);
  CAIRN_CHECK(OptionsAsJson(again) == json, "what is written reads back");
  return 0;
}
