// Learns a codebook from a reconstruction: PCA projection and product quantizer (FAISS).
#ifndef CAIRN_INGEST_QUANTIZE_TRAIN_CODEBOOK_H_
#define CAIRN_INGEST_QUANTIZE_TRAIN_CODEBOOK_H_

#include <cstdint>

#include "ingest/reconstruction.h"
#include "storage/codebook.h"

namespace cairn {

struct CodebookOptions {
  int projected_dim = 16;  // Paper: diminishing returns above 16.
  int num_subspaces = 8;   // Bytes a descriptor; 8 x 256 words lose 2 % recall, 4 lose 17 %.
  int max_training_descriptors = 100'000;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) unless num_subspaces divides projected_dim.
  void Validate() const;
};

// Trains on the descriptors that belong to landmarks. Throws Error(kBadInput) if there are fewer
// than 256 of them or the dimension is below projected_dim. Deterministic by seed.
Codebook TrainCodebook(const Reconstruction& reconstruction, const CodebookOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_QUANTIZE_TRAIN_CODEBOOK_H_
