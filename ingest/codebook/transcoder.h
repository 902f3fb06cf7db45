// From the codes of one codebook to those of another.
#ifndef CAIRN_INGEST_CODEBOOK_TRANSCODER_H_
#define CAIRN_INGEST_CODEBOOK_TRANSCODER_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "storage/codebook/codebook.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/tile.h"

namespace cairn {

// Returns why codes of `from` cannot become codes of `to`, or an empty string: the descriptors or
// their normalization differ.
std::string WhyNotTranscodable(const Codebook& from, const Codebook& to);

// Decodes a code to the projected descriptor y, takes it back to the space of normalized
// descriptors, x = mean + pinv(projection) y, projects x with the other codebook, and encodes it.
// Dimensions that the old projection left out stay lost: x has the mean there, which is the
// least-squares estimate if the projection holds principal components. Immutable; safe to use from
// any thread.
class Transcoder {
 public:
  // Throws Error(kBadInput) with the reason if the codes of `from` cannot become codes of `to`.
  Transcoder(std::shared_ptr<const Codebook> from, std::shared_ptr<const Codebook> to);

  const Codebook& target() const { return to_.codebook(); }

  // codes: n x num_subspaces bytes of the one codebook -> n x num_subspaces bytes of the other.
  std::vector<uint8_t> Transcode(const std::vector<uint8_t>& codes) const;

  // Transcodes all descriptors of a tile, which then names the target as its codebook.
  void Transcode(Tile* tile) const;

 private:
  DescriptorCodec from_;
  DescriptorCodec to_;
  DescriptorMatrix to_from_projected_;  // Transposed: from's projected_dim x to's projected_dim.
  Eigen::RowVectorXf offset_;           // to's projected_dim.
};

}  // namespace cairn

#endif  // CAIRN_INGEST_CODEBOOK_TRANSCODER_H_
