// The parts of a keypoint that not every extractor gives.
#ifndef CAIRN_CORE_KEYPOINT_SHAPE_H_
#define CAIRN_CORE_KEYPOINT_SHAPE_H_

#include <cmath>
#include <limits>

#include "core/features.h"

namespace cairn {

// Features other than SIFT may have no size, no orientation or neither. Keypoint::scale_px and
// Keypoint::orientation_rad then have these values, and whatever uses sizes or orientations leaves
// the term of this keypoint out. A physical size in meters of a tile is 0 if it is unknown.
inline constexpr float kUnknownScalePx = 0.0f;
inline constexpr float kUnknownOrientationRad = std::numeric_limits<float>::quiet_NaN();

inline bool HasScale(const Keypoint& keypoint) { return keypoint.scale_px > 0.0f; }
inline bool HasOrientation(const Keypoint& keypoint) {
  return !std::isnan(keypoint.orientation_rad);
}

inline Keypoint KeypointWithoutShape(float x_px, float y_px) {
  return {x_px, y_px, kUnknownScalePx, kUnknownOrientationRad};
}

}  // namespace cairn

#endif  // CAIRN_CORE_KEYPOINT_SHAPE_H_
