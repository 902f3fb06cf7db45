// The name of a codebook in all maps.
#ifndef CAIRN_STORAGE_CODEBOOK_CODEBOOK_DIGEST_H_
#define CAIRN_STORAGE_CODEBOOK_CODEBOOK_DIGEST_H_

#include <string>

#include "storage/codebook/codebook.h"

namespace cairn {

// The XXH3-128 hash of the codebook's bytes, 32 hexadecimal digits: MapSnapshot::CodebookDigest of
// the maps that have it.
std::string DigestOf(const Codebook& codebook);

}  // namespace cairn

#endif  // CAIRN_STORAGE_CODEBOOK_CODEBOOK_DIGEST_H_
