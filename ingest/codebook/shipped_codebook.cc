#include "ingest/codebook/shipped_codebook.h"

#include "ingest/codebook/shipped_codebook_bytes.h"

namespace cairn {

std::shared_ptr<const Codebook> ShippedCodebook() {
  constexpr std::string_view kBytes = shipped_codebook::k_shipped_codebook;
  return std::make_shared<const Codebook>(
      DecodeCodebook(reinterpret_cast<const uint8_t*>(kBytes.data()), kBytes.size(), CodebookId{}));
}

bool IsShipped(const Codebook& codebook) {
  return EncodeCodebook(codebook) == EncodeCodebook(*ShippedCodebook());
}

}  // namespace cairn
