#include "engine/pose/evidence/evidence_model.h"

#include <cmath>

#include "core/require.h"

namespace cairn {
namespace {

void RequireTrait(const TraitModel& trait, const char* what) {
  RequireOption(trait.weight >= 0.0 && std::isfinite(trait.weight) && trait.scale > 0.0 &&
                    std::isfinite(trait.scale),
                what);
}

}  // namespace

double TraitModel::LogRatio(double deviation) const {
  const double z = deviation / scale;
  return -weight * std::log1p(z * z);
}

void EvidenceModel::Validate() const {
  const auto is_positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  RequireOption(is_positive(error_px) && error_per_scale >= 0.0 && std::isfinite(error_per_scale) &&
                    landmark_share >= 0.0 && std::isfinite(landmark_share),
                "pose.evidence: error_px must be positive; error_per_scale and landmark_share must "
                "be finite and not negative");
  RequireOption(is_positive(error_degrees_of_freedom),
                "pose.evidence.error_degrees_of_freedom must be positive");
  RequireOption(std::isfinite(offset) && std::isfinite(orientation_offset),
                "pose.evidence: offsets must be finite");
  RequireOption(distance_weight >= 0.0 && std::isfinite(distance_weight),
                "pose.evidence.distance_weight must be finite and not negative");
  RequireTrait(size, "pose.evidence.size: need weight >= 0 and scale > 0");
  RequireTrait(orientation, "pose.evidence.orientation: need weight >= 0 and scale > 0");
  RequireTrait(azimuth, "pose.evidence.azimuth: need weight >= 0 and scale > 0");
}

}  // namespace cairn
