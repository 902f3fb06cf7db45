// The codebook that comes with Cairn. Sessions that have too few descriptors to train a
// codebook use it. Maps that share it can be merged.
#ifndef CAIRN_INGEST_CODEBOOK_SHIPPED_CODEBOOK_H_
#define CAIRN_INGEST_CODEBOOK_SHIPPED_CODEBOOK_H_

#include <memory>

#include "storage/codebook/codebook.h"

namespace cairn {

// For 128-D SIFT, with the shape of CodebookOptions' defaults. `cairn-lab codebook` makes it of
// rendered streets. The bytes are part of the library, so every installation has them.
std::shared_ptr<const Codebook> ShippedCodebook();

// Returns whether a codebook is the shipped one, whatever its id.
bool IsShipped(const Codebook& codebook);

}  // namespace cairn

#endif  // CAIRN_INGEST_CODEBOOK_SHIPPED_CODEBOOK_H_
