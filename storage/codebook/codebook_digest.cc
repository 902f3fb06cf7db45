#include "storage/codebook/codebook_digest.h"

#include "storage/tile/content_digest.h"

namespace cairn {

std::string DigestOf(const Codebook& codebook) { return ContentDigest(EncodeCodebook(codebook)); }

}  // namespace cairn
