#include "lab/city/clutter.h"

#include <cmath>

#include "core/angles.h"
#include "core/check.h"
#include "lab/city/hashed_random.h"

namespace cairn {

void AppendClutter(const Camera& camera, const DetectorOptions& detector,
                   const DescriptorModel& model, uint64_t seed, int count, FeatureSet* features) {
  CAIRN_CHECK(features->descriptors.rows() == features->size() + count,
              "descriptors have one row per keypoint");
  const double ratio = detector.min_scale_px / detector.max_scale_px;
  for (int i = 0; i < count; ++i) {
    const uint64_t number = HashOf(seed, i);
    HashedRandom random(number);
    Keypoint keypoint;
    keypoint.x_px = static_cast<float>(random.Uniform(0.0, camera.width_px()));
    keypoint.y_px = static_cast<float>(random.Uniform(0.0, camera.height_px()));
    keypoint.scale_px =
        static_cast<float>(detector.min_scale_px / std::sqrt(random.Uniform(ratio * ratio, 1.0)));
    keypoint.orientation_rad = static_cast<float>(random.Uniform(-kPi, kPi));
    features->descriptors.row(features->size()) = model.DescribeClutter(number);
    features->keypoints.push_back(keypoint);
  }
}

}  // namespace cairn
