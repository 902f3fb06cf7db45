#include "core/features/sift/sift_extractor.h"

#include <fmt/format.h>

#include "core/features/sift/sift_descriptor.h"
#include "core/features/sift/sift_search.h"
#include "core/require.h"

namespace cairn {

void SiftOptions::Validate() const {
  RequireOption(max_features >= 1, "sift.max_features must be at least 1");
  RequireOption(max_pixels >= 1, "sift.max_pixels must be at least 1");
}

FeatureSet ExtractSift(const GrayImage& image, const SiftOptions& options,
                       const StopFunction& should_stop) {
  FeatureSet features;
  for (SiftSearch search(image, options, should_stop); !search.is_done();) {
    search.AddNextOctave(&features);
  }
  return features;
}

int SiftExtractor::descriptor_dim() const { return kSiftDim; }

std::string SiftExtractor::settings() const {
  return fmt::format("{} {}", options_.max_features, options_.max_pixels);
}

}  // namespace cairn
