// Applies a codebook: the one encoder that ingest and engine share.
#ifndef CAIRN_STORAGE_CODEBOOK_DESCRIPTOR_CODEC_H_
#define CAIRN_STORAGE_CODEBOOK_DESCRIPTOR_CODEC_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "core/features.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Normalises rows in place as the codebook asks. All-zero rows stay zero.
void NormalizeDescriptors(DescriptorNormalization normalization, DescriptorMatrix* descriptors);

// Immutable; safe to use from any thread.
class DescriptorCodec {
 public:
  // Throws Error(kBadInput) if the codebook is not valid.
  explicit DescriptorCodec(std::shared_ptr<const Codebook> codebook);

  const Codebook& codebook() const { return *codebook_; }

  // raw: n x raw_dim -> n x projected_dim. Throws Error(kBadInput), naming both dimensions, if the
  // descriptors' dimension is not the codebook's.
  DescriptorMatrix Project(const DescriptorMatrix& raw) const;

  // Brings features of either space to the projected space; throws as Project.
  DescriptorMatrix ProjectFeatures(const FeatureSet& features) const;

  // projected: n x projected_dim -> n x num_subspaces bytes, row-major.
  std::vector<uint8_t> Encode(const DescriptorMatrix& projected) const;

  // codes: n x num_subspaces bytes -> n x projected_dim.
  DescriptorMatrix Decode(const uint8_t* codes, int num_codes) const;

 private:
  std::shared_ptr<const Codebook> codebook_;
  std::vector<float> transposed_words_;  // num_subspaces x subspace_dim x 256, for Encode.
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_CODEBOOK_DESCRIPTOR_CODEC_H_
