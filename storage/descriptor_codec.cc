#include "storage/descriptor_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"

namespace cairn {
namespace {

// Words are compared in blocks of so many, each lane keeping its own minimum: a loop that compilers
// turn into vector instructions without being allowed to reorder floating-point sums.
constexpr int kNumLanes = 16;
static_assert(Codebook::kNumWords % kNumLanes == 0);
constexpr int kNumBlocks = Codebook::kNumWords / kNumLanes;

void ThrowDimension(const char* what, Eigen::Index actual, int expected) {
  throw Error(ErrorCode::kBadInput, std::string(what) + " have " + std::to_string(actual) +
                                        " dimensions, the map's codebook expects " +
                                        std::to_string(expected));
}

// Index of the word nearest to `piece` (kDim floats), the lowest on a tie. `words` is transposed:
// kDim x kNumWords. kDim is 0 if the dimension is known only at run time.
template <int kDim>
uint8_t NearestWord(const float* piece, const float* words, int dim) {
  const int num_dims = kDim > 0 ? kDim : dim;
  std::array<float, kNumLanes> best;
  std::array<int32_t, kNumLanes> best_block{};
  best.fill(std::numeric_limits<float>::infinity());
  for (int block = 0; block < kNumBlocks; ++block) {
    std::array<float, kNumLanes> sq_dist{};
    for (int d = 0; d < num_dims; ++d) {
      const float* word = words + d * Codebook::kNumWords + block * kNumLanes;
      for (int lane = 0; lane < kNumLanes; ++lane) {
        const float difference = piece[d] - word[lane];
        sq_dist[lane] += difference * difference;
      }
    }
    for (int lane = 0; lane < kNumLanes; ++lane) {
      const bool closer = sq_dist[lane] < best[lane];
      best[lane] = closer ? sq_dist[lane] : best[lane];
      best_block[lane] = closer ? block : best_block[lane];
    }
  }
  int best_lane = 0;
  for (int lane = 1; lane < kNumLanes; ++lane) {
    if (best[lane] < best[best_lane] ||
        (best[lane] == best[best_lane] && best_block[lane] < best_block[best_lane])) {
      best_lane = lane;
    }
  }
  return static_cast<uint8_t>(best_block[best_lane] * kNumLanes + best_lane);
}

template <int kDim>
void EncodeRows(const DescriptorMatrix& projected, const std::vector<float>& transposed_words,
                int num_subspaces, uint8_t* codes) {
  const int dim = static_cast<int>(projected.cols()) / num_subspaces;
  for (Eigen::Index row = 0; row < projected.rows(); ++row) {
    const float* piece = projected.row(row).data();
    const float* words = transposed_words.data();
    for (int s = 0; s < num_subspaces; ++s) {
      *codes++ = NearestWord<kDim>(piece, words, dim);
      piece += dim;
      words += dim * Codebook::kNumWords;
    }
  }
}

}  // namespace

void NormalizeDescriptors(DescriptorNormalization normalization, DescriptorMatrix* descriptors) {
  if (normalization == DescriptorNormalization::kNone) {
    return;
  }
  for (Eigen::Index row = 0; row < descriptors->rows(); ++row) {
    auto descriptor = descriptors->row(row);
    const float l1_norm = descriptor.lpNorm<1>();
    if (l1_norm > 0.0f) {
      // Elements of a histogram are not negative; signs of others survive.
      descriptor = descriptor.unaryExpr([l1_norm](float value) {
        return std::copysign(std::sqrt(std::abs(value) / l1_norm), value);
      });
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
  if (codebook_->subspace_dim() == 2) {
    EncodeRows<2>(projected, transposed_words_, codebook_->num_subspaces, codes.data());
  } else {
    EncodeRows<0>(projected, transposed_words_, codebook_->num_subspaces, codes.data());
  }
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
