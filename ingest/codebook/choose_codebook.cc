#include "ingest/codebook/choose_codebook.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/codebook/shipped_codebook.h"

namespace cairn {
namespace {

int64_t CountLandmarkDescriptors(const Reconstruction& reconstruction) {
  int64_t count = 0;
  for (const ReconLandmark& landmark : reconstruction.landmarks) {
    count += static_cast<int64_t>(landmark.observations.size());
  }
  return count;
}

bool FitsDescriptors(const Codebook& shipped, const Reconstruction& reconstruction) {
  return shipped.descriptor_type == reconstruction.descriptor_type &&
         shipped.raw_dim() == reconstruction.descriptor_dim();
}

bool FitsOptions(const Codebook& shipped, const CodebookOptions& options) {
  return options.projection == ProjectionKind::kPrincipalComponents &&
         shipped.projected_dim() == options.projected_dim &&
         shipped.num_subspaces == options.num_subspaces;
}

void RequireFits(const Codebook& shipped, const Reconstruction& reconstruction,
                 const CodebookOptions& options) {
  if (!FitsDescriptors(shipped, reconstruction)) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("the shipped codebook is for {}-D descriptors of type '{}', the "
                    "reconstruction has {}-D ones of type '{}'; train a codebook instead",
                    shipped.raw_dim(), shipped.descriptor_type, reconstruction.descriptor_dim(),
                    Excerpt(reconstruction.descriptor_type)));
  }
  if (!FitsOptions(shipped, options)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("the shipped codebook has principal components, {} dimensions and {} "
                            "bytes a descriptor; to use other options of the codebook, train one",
                            shipped.projected_dim(), shipped.num_subspaces));
  }
}

bool ShouldTrain(const Codebook& shipped, const Reconstruction& reconstruction,
                 const CodebookOptions& options) {
  return !FitsDescriptors(shipped, reconstruction) || !FitsOptions(shipped, options) ||
         CountLandmarkDescriptors(reconstruction) >= options.min_training_descriptors;
}

}  // namespace

std::shared_ptr<const Codebook> ChooseCodebook(const Reconstruction& reconstruction,
                                               const CodebookOptions& options) {
  std::shared_ptr<const Codebook> shipped = ShippedCodebook();
  if (options.source == CodebookSource::kShipped) {
    RequireFits(*shipped, reconstruction, options);
    return shipped;
  }
  if (options.source == CodebookSource::kTrained ||
      ShouldTrain(*shipped, reconstruction, options)) {
    return std::make_shared<const Codebook>(TrainCodebook(reconstruction, options));
  }
  return shipped;
}

}  // namespace cairn
