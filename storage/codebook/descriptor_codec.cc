#include "storage/codebook/descriptor_codec.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/simd.h"

namespace cairn {
namespace {

// Compares eight words at a time; each lane keeps its own minimum. The code uses vector types
// because compilers unroll the equivalent loops over lanes before they recognize them as vector
// operations.
constexpr int kNumLanes = 8;
using FloatLanes = Lanes<float, kNumLanes>;
using IntLanes = Lanes<int32_t, kNumLanes>;
static_assert(Codebook::kNumWords % kNumLanes == 0);

void ThrowDimension(const char* what, Eigen::Index actual, int expected) {
  throw Error(ErrorCode::kBadInput, std::string(what) + " have " + std::to_string(actual) +
                                        " dimensions, the map's codebook expects " +
                                        std::to_string(expected));
}

// Returns the index of the word nearest to `piece` (kDim floats), the lowest index on a tie.
// `words` is transposed: kDim x kNumWords. kDim is 0 if the dimension is known only at run time.
template <int kDim>
[[gnu::always_inline]] inline uint8_t NearestWord(const float* piece, const float* words, int dim) {
  const int num_dims = kDim > 0 ? kDim : dim;
  FloatLanes best = FloatLanes{} + std::numeric_limits<float>::infinity();
  IntLanes best_begin{};  // For each lane, the first word of the block that holds its best word.
  for (int begin = 0; begin < Codebook::kNumWords; begin += kNumLanes) {
    FloatLanes sq_dist{};
    for (int d = 0; d < num_dims; ++d) {
      FloatLanes word;
      std::memcpy(&word, words + d * Codebook::kNumWords + begin, sizeof(word));
      const FloatLanes difference = piece[d] - word;
      sq_dist += difference * difference;
    }
    const IntLanes closer = sq_dist < best;
    best = closer ? sq_dist : best;
    best_begin = closer ? IntLanes{} + begin : best_begin;
  }
  int nearest = best_begin[0];
  float nearest_sq_dist = best[0];
  for (int lane = 1; lane < kNumLanes; ++lane) {
    const int word = best_begin[lane] + lane;
    if (best[lane] < nearest_sq_dist || (best[lane] == nearest_sq_dist && word < nearest)) {
      nearest = word;
      nearest_sq_dist = best[lane];
    }
  }
  return static_cast<uint8_t>(nearest);
}

// projected: num_rows x (num_subspaces * dim); codes: num_rows x num_subspaces.
CAIRN_EXACT_VECTOR_CLONES void EncodeRows(const float* projected, Eigen::Index num_rows,
                                          int num_subspaces, int dim, const float* transposed_words,
                                          uint8_t* codes) {
  for (Eigen::Index row = 0; row < num_rows; ++row) {
    const float* words = transposed_words;
    for (int s = 0; s < num_subspaces; ++s) {
      *codes++ =
          dim == 2 ? NearestWord<2>(projected, words, dim) : NearestWord<0>(projected, words, dim);
      projected += dim;
      words += dim * Codebook::kNumWords;
    }
  }
}

}  // namespace

void NormalizeDescriptors(DescriptorNormalization normalization, DescriptorMatrix* descriptors) {
  if (normalization == DescriptorNormalization::kNone) {
    return;
  }
  Eigen::Array<float, 1, Eigen::Dynamic> roots(descriptors->cols());
  for (Eigen::Index row = 0; row < descriptors->rows(); ++row) {
    auto descriptor = descriptors->row(row).array();
    const float l1_norm = descriptor.abs().sum();
    if (l1_norm > 0.0f) {
      // Histogram elements are never negative. For other descriptors the signs are kept.
      roots = (descriptor.abs() / l1_norm).sqrt();
      descriptor = (descriptor < 0.0f).select(-roots, roots);
    }
  }
}

DescriptorCodec::DescriptorCodec(std::shared_ptr<const Codebook> codebook)
    : codebook_(std::move(codebook)) {
  codebook_->Validate();
  const int dim = codebook_->subspace_dim();
  transposed_words_.resize(codebook_->words.size());
  const float* words = codebook_->words.data();
  float* transposed = transposed_words_.data();
  for (int s = 0; s < codebook_->num_subspaces; ++s) {
    for (int word = 0; word < Codebook::kNumWords; ++word) {
      for (int d = 0; d < dim; ++d) {
        transposed[d * Codebook::kNumWords + word] = *words++;
      }
    }
    transposed += dim * Codebook::kNumWords;
  }
}

DescriptorMatrix DescriptorCodec::Project(const DescriptorMatrix& raw) const {
  if (raw.cols() != codebook_->raw_dim()) {
    ThrowDimension("raw descriptors", raw.cols(), codebook_->raw_dim());
  }
  DescriptorMatrix normalized = raw;
  NormalizeDescriptors(codebook_->normalization, &normalized);
  normalized.rowwise() -= codebook_->mean.transpose();
  return normalized * codebook_->projection.transpose();
}

DescriptorMatrix DescriptorCodec::ProjectFeatures(const FeatureSet& features) const {
  if (features.space == DescriptorSpace::kRaw) {
    return Project(features.descriptors);
  }
  if (features.descriptors.cols() != codebook_->projected_dim()) {
    ThrowDimension("projected descriptors", features.descriptors.cols(),
                   codebook_->projected_dim());
  }
  return features.descriptors;
}

std::vector<uint8_t> DescriptorCodec::Encode(const DescriptorMatrix& projected) const {
  if (projected.cols() != codebook_->projected_dim()) {
    ThrowDimension("projected descriptors", projected.cols(), codebook_->projected_dim());
  }
  std::vector<uint8_t> codes(projected.rows() * codebook_->num_subspaces);
  EncodeRows(projected.data(), projected.rows(), codebook_->num_subspaces,
             codebook_->subspace_dim(), transposed_words_.data(), codes.data());
  return codes;
}

DescriptorMatrix DescriptorCodec::Decode(const uint8_t* codes, int num_codes) const {
  const int dim = codebook_->subspace_dim();
  DescriptorMatrix projected(num_codes, codebook_->projected_dim());
  float* out = projected.data();
  for (int row = 0; row < num_codes; ++row) {
    const float* words = codebook_->words.data();
    for (int s = 0; s < codebook_->num_subspaces; ++s) {
      out = std::copy_n(words + *codes++ * dim, dim, out);
      words += Codebook::kNumWords * dim;
    }
  }
  return projected;
}

}  // namespace cairn
