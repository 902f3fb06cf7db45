// The description (core/option_visit.h) of CodebookOptions.
#ifndef CAIRN_INGEST_CODEBOOK_CODEBOOK_OPTION_VISIT_H_
#define CAIRN_INGEST_CODEBOOK_CODEBOOK_OPTION_VISIT_H_

#include "core/option_visit.h"
#include "ingest/codebook/train_codebook.h"

namespace cairn {

template <OptionsOf<CodebookOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [source, min_training_descriptors, projection, projected_dim, num_subspaces,
         max_training_descriptors, seed] = options;
  visitor.Visit("source", source, AnyValue(),
                "Codebook of a new map: the one that comes with Cairn, one that is trained on the "
                "first session, or (auto) trained if the session has min_training_descriptors, "
                "else shipped");
  visitor.Visit(
      "min_training_descriptors", min_training_descriptors, AtLeast(0),
      "For auto: fewest descriptors of landmarks in the first session that train a codebook");
  visitor.Visit("projection", projection, AnyValue(),
                "principal_components keeps what varies most; likelihood_ratio keeps what tells "
                "landmarks apart");
  visitor.Visit("projected_dim", projected_dim, WithinOf(1, 256),
                "Dimensions of a descriptor after the projection");
  visitor.Visit("num_subspaces", num_subspaces, WithinOf(1, 64),
                "Bytes of a descriptor; has to divide projected_dim");
  visitor.Visit("max_training_descriptors", max_training_descriptors, AtLeast(Codebook::kNumWords),
                "Most descriptors that the codebook is trained on");
  visitor.Visit("seed", seed, AnyValue(), "Seed of the training");
}

}  // namespace cairn

#endif  // CAIRN_INGEST_CODEBOOK_CODEBOOK_OPTION_VISIT_H_
