// Codebooks: a decoded codebook must be valid and have exactly one encoding.
#include <algorithm>

#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/seal.h"
#include "storage/codebook/codebook.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kChecksumOffset = 32;
  const std::vector<uint8_t> bytes = cairn::testing::Sealed(data, size, kChecksumOffset);
  cairn::Codebook codebook;
  try {
    codebook = cairn::DecodeCodebook(bytes.data(), bytes.size(), cairn::CodebookId(1));
  } catch (const cairn::Error& error) {
    CAIRN_CHECK(error.code() == cairn::ErrorCode::kMapDamaged, error.what());
    return 0;
  }
  codebook.Validate();
  const std::vector<uint8_t> again = cairn::EncodeCodebook(codebook);
  CAIRN_CHECK(again == cairn::EncodeCodebook(
                           cairn::DecodeCodebook(again.data(), again.size(), codebook.id)),
              "a codebook changes when it is encoded and decoded again");
  return 0;
}
