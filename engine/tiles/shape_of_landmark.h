// Finds the shape of the error of a landmark from the keyframes that saw it.
#ifndef CAIRN_ENGINE_TILES_SHAPE_OF_LANDMARK_H_
#define CAIRN_ENGINE_TILES_SHAPE_OF_LANDMARK_H_

#include <cstdint>

#include "engine/query/landmark_shape.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Returns the shape in the tile's frame. The size of the covariance is that of the standard
// deviation that the tile stores; its shape is that of a point which the tile's keyframes that saw
// the landmark triangulate: cameras that stand close together know the direction of a point far
// better than its distance. A landmark that no keyframe of the tile saw is as uncertain along each
// axis. Linear in the number of keyframes that saw the landmark.
LandmarkShape ShapeOfLandmark(const SearchableTile& tile, uint32_t landmark_idx);

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_SHAPE_OF_LANDMARK_H_
