// Colors of landmarks.
#ifndef CAIRN_CLI_EXPORTS_POINT_COLORS_H_
#define CAIRN_CLI_EXPORTS_POINT_COLORS_H_

#include <array>
#include <cstdint>

#include "storage/ids.h"

namespace cairn {

using Rgb = std::array<uint8_t, 3>;

enum class PointColor {
  kSession,      // Of the oldest session that is known to have seen the landmark.
  kHeight,       // Above the cameras of its tile: from -5 m (blue) to 25 m (red).
  kUncertainty,  // The standard deviation of its position: from 1 cm (blue) to 1 m (red).
};

// Ten colors in turn; gray for session 0, which stands for old ones.
Rgb ColorOfSession(SessionId session_id);
Rgb ColorOfHeight(double height_over_cameras_m);
Rgb ColorOfUncertainty(double sigma_m);

}  // namespace cairn

#endif  // CAIRN_CLI_EXPORTS_POINT_COLORS_H_
