// Trains a codebook from a reconstruction: PCA projection and product quantizer (FAISS).
#ifndef CAIRN_INGEST_CODEBOOK_TRAIN_CODEBOOK_H_
#define CAIRN_INGEST_CODEBOOK_TRAIN_CODEBOOK_H_

#include <cstdint>

#include "core/scene/reconstruction.h"
#include "storage/codebook/codebook.h"

namespace cairn {

enum class ProjectionKind {
  kPrincipalComponents,  // Keeps what varies most.
  kLikelihoodRatio,      // Keeps what tells landmarks apart (Bosse and Zlot 2009).
};

// Where the codebook of a new map comes from; see choose_codebook.h.
enum class CodebookSource {
  kAuto,     // Trained if the first session has enough descriptors, else shipped.
  kShipped,  // Comes with Cairn.
  kTrained,  // On the first session.
};

struct CodebookOptions {
  CodebookSource source = CodebookSource::kAuto;
  // A first session with fewer descriptors of landmarks gets the shipped codebook. Training needs
  // 256. Trained on three photos, a codebook finds more inliers than the shipped one, and answers
  // as many queries; see docs/figures.md.
  int min_training_descriptors = 256;
  ProjectionKind projection = ProjectionKind::kPrincipalComponents;
  int projected_dim = 16;  // The paper finds diminishing returns above 16.
  int num_subspaces = 8;   // Bytes per descriptor; 8 x 256 words lose 2 % recall, 4 lose 17 %.
  // More descriptors hardly make the codebook better, and training takes longer (docs/figures.md).
  int max_training_descriptors = 40'000;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) unless num_subspaces divides projected_dim.
  void Validate() const;
};

// Trains on the descriptors that belong to landmarks. Throws Error(kBadInput) if there are fewer
// than 256 such descriptors or if the dimension is below projected_dim. Deterministic for a given
// seed.
Codebook TrainCodebook(const Reconstruction& reconstruction, const CodebookOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_CODEBOOK_TRAIN_CODEBOOK_H_
