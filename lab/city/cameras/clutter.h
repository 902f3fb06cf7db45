// Keypoints that belong to nothing.
#ifndef CAIRN_LAB_CITY_CAMERAS_CLUTTER_H_
#define CAIRN_LAB_CITY_CAMERAS_CLUTTER_H_

#include <cstdint>

#include "core/camera.h"
#include "core/features.h"
#include "lab/city/cameras/detector.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

// Appends keypoints anywhere in the image, with scales distributed as those of landmarks are and
// with descriptors from the model. `features->descriptors` must have the rows for them: `count`
// more than there are keypoints.
void AppendClutter(const Camera& camera, const DetectorOptions& detector,
                   const DescriptorModel& model, uint64_t seed, int count, FeatureSet* features);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CAMERAS_CLUTTER_H_
