// Builds a street as textured rectangles: houses, their relief, street furniture and the ground.
#ifndef CAIRN_CLI_DEMO_STREET_BUILD_STREET_H_
#define CAIRN_CLI_DEMO_STREET_BUILD_STREET_H_

#include <vector>

#include "cli/demo/street/renderer.h"
#include "cli/demo/street/street_scene.h"
#include "core/rigid3.h"

namespace cairn {

// Returns the pose of the street frame: x along the street from 0 to length_m, y to the left, z up
// from the pavement. The middle of the street is the origin of the scene's enu frame.
Rigid3d EnuFromStreet(const StreetOptions& options);

// Width of each pavement.
inline constexpr double kSidewalkM = 3.0;

// Builds houses on both sides and across both ends of the street, in enu. Bay windows, balconies,
// columns and cornices stand out of their fronts. Kiosks, advertising columns and signs stand on
// the pavements.
std::vector<TexturedRect> BuildStreet(const StreetOptions& options);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_BUILD_STREET_H_
