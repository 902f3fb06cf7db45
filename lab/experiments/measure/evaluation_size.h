// What a map costs in storage.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_EVALUATION_SIZE_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_EVALUATION_SIZE_H_

#include "storage/map/map_store.h"

namespace cairn {

// Encoded tile payloads only; the rest of the file (index, keyframe rows, free pages) is
// file_overhead. Ratios are zero if the map is empty.
struct MapSizes {
  double bytes_per_tile = 0.0;
  double bytes_per_landmark = 0.0;    // Everything in the payload, descriptors too.
  double bytes_per_descriptor = 0.0;  // Everything in the payload, landmarks too.
  double descriptors_per_landmark = 0.0;
  double file_overhead = 0.0;  // File bytes over payload bytes, minus one.
};

MapSizes MeasureMapSizes(const MapInfo& info);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_EVALUATION_SIZE_H_
