// The codebook that a user names.
#ifndef CAIRN_INGEST_CODEBOOK_LOAD_CODEBOOK_H_
#define CAIRN_INGEST_CODEBOOK_LOAD_CODEBOOK_H_

#include <memory>
#include <string>

#include "storage/codebook/codebook.h"

namespace cairn {

// `source` is the word "shipped" (see ShippedCodebook), the path or URL of a map, whose current
// codebook it names, or a file with the bytes of docs/formats/codebook_v1.md. The id of the result
// has no meaning. Throws Error(kBadInput) if the map has no codebook yet, Error(kMapDamaged) if the
// file does not decode, and what MapStore::Open throws.
std::shared_ptr<const Codebook> LoadCodebook(const std::string& source);

}  // namespace cairn

#endif  // CAIRN_INGEST_CODEBOOK_LOAD_CODEBOOK_H_
