// The CSV of `cairn ingest --georef`.
#include "core/error.h"
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_target.h"
#include "ingest/place/georegister.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  try {
    ReadCameraPositions(
        cairn::testing::WriteFuzzFile("positions.csv", cairn::testing::AsText(data, size)));
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput, error.what());
  }
  return 0;
}
