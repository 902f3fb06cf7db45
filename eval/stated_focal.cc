#include "eval/stated_focal.h"

#include "core/focal_length.h"
#include "core/require.h"

namespace cairn {
namespace {

// One bit from the name and the seed: FNV-1a, followed by the last step of MurmurHash3, because FNV
// barely mixes the last letters.
bool IsTooLong(const EvalQuery& query, uint64_t seed) {
  uint64_t hash = 0xcbf29ce484222325 ^ seed;
  for (const char letter : query.name) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3;
  }
  hash = (hash ^ hash >> 33) * 0xff51afd7ed558ccd;
  hash = (hash ^ hash >> 33) * 0xc4ceb9fe1a85ec53;
  return (hash >> 63) != 0;
}

}  // namespace

void StatedFocalOptions::Validate() const {
  RequireWithin("focal.error", error, 0.0, 0.5);
  if (sigma) {
    RequireWithin("focal.sigma", *sigma, FocalPrior::kMinLogSigma, FocalPrior::kMaxLogSigma);
  }
  RequireOption(!withheld || (error == 0.0 && !sigma),
                "focal.withheld excludes focal.error and focal.sigma");
}

void StateFocalLengths(const StatedFocalOptions& options, std::vector<EvalQuery>* queries) {
  options.Validate();
  for (EvalQuery& query : *queries) {
    LocalizeQuery& asked = query.query;
    if (options.withheld) {
      asked.camera = CameraOfUnknownFocal(asked.camera.width_px(), asked.camera.height_px());
      asked.focal = FocalPrior{.with_distortion = true};
      continue;
    }
    const double factor =
        IsTooLong(query, options.seed) ? 1.0 + options.error : 1.0 / (1.0 + options.error);
    asked.camera = WithFocalScaled(asked.camera, factor);
    if (options.sigma) {
      asked.focal = FocalPrior{.log_sigma = *options.sigma};
    }
  }
}

}  // namespace cairn
