#include "engine/query/localize_query.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "core/error.h"

namespace cairn {
namespace {

void ValidateRigCamera(const RigCamera& other, DescriptorSpace space, size_t index) {
  const std::string name = fmt::format("rig[{}]", index);
  ValidateFeatures(other.features, (name + ".features").c_str());
  if (other.features.size() > 0 && other.features.space != space) {
    throw Error(ErrorCode::kBadInput,
                name + ".features: raw and projected features cannot be mixed in one query");
  }
  if (!other.cam_from_first.rotation.coeffs().allFinite() ||
      !(other.cam_from_first.translation.norm() <= RigCamera::kMaxOffsetM)) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{}.camFromFirst: the cameras of a rig must lie within {} m of the first", name,
                    RigCamera::kMaxOffsetM));
  }
}

}  // namespace

int LocalizeQuery::num_features() const {
  int count = features.size();
  for (const RigCamera& other : other_cameras) {
    count += other.features.size();
  }
  return count;
}

void LocalizeQuery::Validate() const {
  ValidateFeatures(features, "features");
  if (other_cameras.size() > RigCamera::kMaxOthers) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("rig: {} cameras besides the first; at most {} are allowed",
                            other_cameras.size(), RigCamera::kMaxOthers));
  }
  for (size_t i = 0; i < other_cameras.size(); ++i) {
    ValidateRigCamera(other_cameras[i], features.space, i);
  }
  if (focal) {
    focal->Validate(camera);
    if (!other_cameras.empty()) {
      throw Error(ErrorCode::kBadInput,
                  "camera: the focal lengths of a rig are not estimated; state them, without "
                  "focalLength and focalLengthSigma");
    }
  }
  if (prior) {
    ValidateGeodetic(prior->position, "prior.position");
    if (!(prior->accuracy_m > 0.0 && prior->accuracy_m <= PositionPrior::kMaxAccuracyM)) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("prior.accuracy: {} m is not within (0, {}]", prior->accuracy_m,
                              PositionPrior::kMaxAccuracyM));
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
