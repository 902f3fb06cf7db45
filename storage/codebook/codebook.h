// The codebook of a map: how descriptors are normalized, projected and quantized.
#ifndef CAIRN_STORAGE_CODEBOOK_CODEBOOK_H_
#define CAIRN_STORAGE_CODEBOOK_CODEBOOK_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/features.h"
#include "storage/ids.h"

namespace cairn {

enum class DescriptorNormalization : uint8_t {
  kNone = 0,
  kRootSift = 1,  // L1-normalize, then square root per element (Arandjelovic and Zisserman 2012).
};

// A plain value. The codebook maps a raw descriptor x (raw_dim) to
//   y = projection * (Normalize(x) - mean)          (projected_dim floats)
// and cuts y into `num_subspaces` pieces of equal length. One byte codes each piece: the index of
// the nearest of 256 words (Jegou et al. 2011). `projection` already contains the permutation that
// balances the variance of the subspaces (Ge et al. 2014).
struct Codebook {
  static constexpr int kNumWords = 256;

  CodebookId id{};
  // Names the extractor, e.g. "sift". Features of another extractor are refused.
  std::string descriptor_type;
  DescriptorNormalization normalization = DescriptorNormalization::kRootSift;
  Eigen::VectorXf mean;         // raw_dim.
  DescriptorMatrix projection;  // projected_dim x raw_dim.
  int num_subspaces = 0;        // Bytes of a code.
  // num_subspaces x 256 x (projected_dim / num_subspaces), in this index order.
  std::vector<float> words;

  // Statistics of the training data, in units of projected distance, from which the matching
  // defaults follow. Each vector has the quantiles 0.05, 0.10, ... 0.95 (19 values) of a distance.
  //
  // Distance between a projected descriptor and the nearest quantized descriptor of the same
  // landmark made from other images.
  std::vector<float> same_landmark_distance_quantiles;
  // Distance between a projected descriptor and the nearest of 10,000 random other landmarks.
  std::vector<float> other_landmark_distance_quantiles;

  int raw_dim() const { return static_cast<int>(mean.size()); }
  int projected_dim() const { return static_cast<int>(projection.rows()); }
  int subspace_dim() const { return num_subspaces == 0 ? 0 : projected_dim() / num_subspaces; }

  // Returns the name of the wire codec that this codebook defines, e.g. "sift-128-16-1". Features
  // in projected space must name the codec of the map they were made for.
  std::string CodecName() const;

  // Throws Error(kBadInput) unless shapes agree and every number is finite.
  void Validate() const;
};

// Encodes a codebook without its id as little-endian bytes; see docs/formats/codebook_v1.md.
std::vector<uint8_t> EncodeCodebook(const Codebook& codebook);

// The inverse of EncodeCodebook. Throws Error(kMapDamaged) if the bytes do not decode.
Codebook DecodeCodebook(const uint8_t* data, size_t size, CodebookId id);

}  // namespace cairn

#endif  // CAIRN_STORAGE_CODEBOOK_CODEBOOK_H_
