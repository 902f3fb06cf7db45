// Which codebook a new map gets.
#ifndef CAIRN_INGEST_CODEBOOK_CHOOSE_CODEBOOK_H_
#define CAIRN_INGEST_CODEBOOK_CHOOSE_CODEBOOK_H_

#include <memory>

#include "core/scene/reconstruction.h"
#include "ingest/codebook/train_codebook.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Follows `options.source`; the id of the result is 0. kAuto takes the shipped codebook if the
// reconstruction has fewer than `options.min_training_descriptors` descriptors of landmarks, and if
// the shipped codebook has the shape that the options ask for. If the source is kShipped, throws
// Error(kBadInput) if the descriptors are not those of the shipped codebook, and
// Error(kInvalidArgument) if the options ask for another shape. Throws as TrainCodebook.
std::shared_ptr<const Codebook> ChooseCodebook(const Reconstruction& reconstruction,
                                               const CodebookOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_CODEBOOK_CHOOSE_CODEBOOK_H_
