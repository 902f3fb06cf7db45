// Boxes of latitudes and longitudes: intersection tests and unions on the circle. Private to
// storage.
#ifndef CAIRN_STORAGE_INSPECTION_GEO_BOX_H_
#define CAIRN_STORAGE_INSPECTION_GEO_BOX_H_

#include <optional>
#include <vector>

#include "core/geodesy.h"

namespace cairn {

// Returns true if the closed boxes have a point in common.
bool BoxesMeet(const GeoBox& a, const GeoBox& b);

// Returns the smallest box that contains all `boxes`; nothing if there are none.
std::optional<GeoBox> BoxAroundAll(std::vector<GeoBox> boxes);

}  // namespace cairn

#endif  // CAIRN_STORAGE_INSPECTION_GEO_BOX_H_
