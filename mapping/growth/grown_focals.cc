#include "mapping/growth/grown_focals.h"

#include <cmath>
#include <utility>

#include "core/focal_length.h"
#include "mapping/growth/camera_freedom.h"

namespace cairn {
namespace {

// Two views found under a focal length that is wrong by less hold: as of EXIF.
const double kLeastLogMove = std::log(1.1);
// Of a focal length from a bent segment: of a drive around a corner, it was found 12 % too long.
constexpr double kGrownLogSigma = 0.15;

// Lenses widen the corners of their pictures by some percent at most. Of drives with a guess that
// was too long, segments widened them by 6 to 23 %, and under the right focal length by 0.5 %.
constexpr double kMaxPincushion = 0.05;
constexpr double kPincushionFactor = 1.5;

double PincushionOf(const Camera& camera) {
  const Eigen::Vector2d corner_px(0.0, 0.0);
  const auto ray = camera.Unproject(corner_px);
  if (!ray || ray->z() <= 0.0) {
    return 0.0;
  }
  const double undistorted_px = camera.focal_px() * ray->head<2>().norm() / ray->z();
  return (corner_px - PrincipalPointPx(camera)).norm() / undistorted_px - 1.0;
}

// From which to grow again.
double FocalOf(const Camera& grown) {
  return grown.focal_px() / (PincushionOf(grown) > kMaxPincushion ? kPincushionFactor : 1.0);
}

bool MayBeWrong(const MappingCamera& camera) {
  return camera.source != FocalSource::kCalibration && camera.source != FocalSource::kExif;
}

// The camera in the segment with the most photos of it; null if that has too few.
const Camera* LargestOf(std::span<const Segment> segments, size_t camera) {
  int most = kMinPhotosToCalibrate - 1;
  const Camera* grown = nullptr;
  for (const Segment& segment : segments) {
    int num_photos = 0;
    for (const ReconImage& image : segment.model.images) {
      num_photos += image.camera_idx == static_cast<int>(camera) ? 1 : 0;
    }
    if (num_photos > most) {
      most = num_photos;
      grown = &segment.model.cameras[camera];
    }
  }
  return grown;
}

}  // namespace

std::optional<std::vector<MappingCamera>> GrownFocals(const PhotoSet& set,
                                                      std::span<const Segment> segments) {
  std::vector<MappingCamera> cameras = set.cameras;
  bool has_moved = false;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const Camera* grown = MayBeWrong(cameras[i]) ? LargestOf(segments, i) : nullptr;
    const double factor = grown ? FocalOf(*grown) / cameras[i].camera.focal_px() : 1.0;
    if (std::abs(std::log(factor)) >= kLeastLogMove) {
      cameras[i].camera = WithFocalScaled(cameras[i].camera, factor);
      cameras[i].focal.log_sigma = kGrownLogSigma;
      cameras[i].source = FocalSource::kGrowth;
      has_moved = true;
    }
  }
  return has_moved ? std::optional(std::move(cameras)) : std::nullopt;
}

}  // namespace cairn
