// Applies a codebook. Ingest and engine share this one encoder.
#ifndef CAIRN_STORAGE_CODEBOOK_DESCRIPTOR_CODEC_H_
#define CAIRN_STORAGE_CODEBOOK_DESCRIPTOR_CODEC_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "core/features.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Normalizes the rows in place. All-zero rows stay zero.
void NormalizeDescriptors(DescriptorNormalization normalization, DescriptorMatrix* descriptors);

// Immutable; safe to use from any thread.
class DescriptorCodec {
 public:
  // Throws Error(kBadInput) if the codebook is not valid.
  explicit DescriptorCodec(std::shared_ptr<const Codebook> codebook);

  const Codebook& codebook() const { return *codebook_; }

  // n x raw_dim -> n x projected_dim. Throws Error(kBadInput), naming both dimensions, if `raw`
  // does not have raw_dim columns.
  DescriptorMatrix Project(const DescriptorMatrix& raw) const;

  // Converts features in either space to projected space. Throws what Project throws.
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
