#include "engine/localize_query.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"

namespace cairn {

void LocalizeQuery::Validate() const {
  ValidateFeatures(features, "features");
  if (prior) {
    ValidateGeodetic(prior->position, "prior.position");
    constexpr double kMaxAccuracyM = 100e3;
    if (!(prior->accuracy_m > 0.0 && prior->accuracy_m <= kMaxAccuracyM)) {
      throw Error(ErrorCode::kBadInput, fmt::format("prior.accuracy: {} m is not within (0, {}]",
                                                    prior->accuracy_m, kMaxAccuracyM));
    }
    if (prior->height_sigma_m && !(*prior->height_sigma_m > 0.0)) {
      throw Error(ErrorCode::kBadInput, fmt::format("prior.altitudeAccuracy: {} m must be positive",
                                                    *prior->height_sigma_m));
    }
  }
  if (down_in_cam && !(std::abs(down_in_cam->norm() - 1.0) < 1e-3)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("gravity: length {} is not 1; send the unit down vector in the camera "
                            "frame (x right, y down, z forward)",
                            down_in_cam->norm()));
  }
}

}  // namespace cairn
