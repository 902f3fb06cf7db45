// Learns a codebook from a reconstruction: PCA projection and product quantizer (FAISS).
#ifndef CAIRN_INGEST_QUANTIZE_TRAIN_CODEBOOK_H_
#define CAIRN_INGEST_QUANTIZE_TRAIN_CODEBOOK_H_

#include <cstdint>

#include "ingest/sfm/reconstruction.h"
#include "storage/codebook/codebook.h"

namespace cairn {

struct CodebookOptions {
  int projected_dim = 16;  // Paper: diminishing returns above 16.
  int num_subspaces = 8;   // Bytes a descriptor; 8 x 256 words lose 2 % recall, 4 lose 17 %.
  // More does not pay: of KITTI's descriptors 0.74 % of the projected variance is lost with 40,000
  // in 3 s of training, 0.71 % with all 53,000 and more iterations in 7 s.
  int max_training_descriptors = 40'000;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) unless num_subspaces divides projected_dim.
  void Validate() const;
};

// Trains on the descriptors that belong to landmarks. Throws Error(kBadInput) if there are fewer
// than 256 of them or the dimension is below projected_dim. Deterministic by seed.
Codebook TrainCodebook(const Reconstruction& reconstruction, const CodebookOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_QUANTIZE_TRAIN_CODEBOOK_H_
