// Adds keypoints that show no landmark.
#ifndef CAIRN_LAB_CITY_CLUTTER_H_
#define CAIRN_LAB_CITY_CLUTTER_H_

#include <cstdint>

#include "core/camera.h"
#include "core/features.h"
#include "lab/city/detector.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

// Appends `count` keypoints at random places in the image. Their scales are distributed like those
// of landmarks, and their descriptors come from the model. `features->descriptors` must already
// have the rows for them: `count` rows more than there are keypoints.
void AppendClutter(const Camera& camera, const DetectorOptions& detector,
                   const DescriptorModel& model, uint64_t seed, int count, FeatureSet* features);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CLUTTER_H_
