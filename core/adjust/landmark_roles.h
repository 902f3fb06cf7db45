// Which landmarks decide the poses of many photos. Private to core/adjust.
#ifndef CAIRN_CORE_ADJUST_LANDMARK_ROLES_H_
#define CAIRN_CORE_ADJUST_LANDMARK_ROLES_H_

#include <cstdint>
#include <vector>

#include "core/adjust/adjust.h"
#include "core/scene/reconstruction.h"

namespace cairn {

enum class LandmarkRole : uint8_t {
  kIdle,     // Only fixed images see it.
  kDecides,  // Its observations are in the problem.
  kFollows,  // It is triangulated again when the poses are solved.
};

// Returns the role of each landmark. All that an image sees which is not fixed decide, unless they
// have more than `max_observations_of_all` observations.
//
// Landmarks with many observations then come first. Each decides if it lies in a part of
// some image's picture, one of 4 x 4, in which fewer than 32 do, or if it ties images that fewer
// than 64 landmarks tie: parts that share little would drift apart without their ties. Fixed
// landmarks always decide: they tie the images to the model that stays.
std::vector<LandmarkRole> RolesOfLandmarks(const Reconstruction& model, const AdjustPriors& priors,
                                           int64_t max_observations_of_all);

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_LANDMARK_ROLES_H_
