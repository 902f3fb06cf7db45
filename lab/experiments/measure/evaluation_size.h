// The storage that a map needs.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_EVALUATION_SIZE_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_EVALUATION_SIZE_H_

#include "storage/map/map_store.h"

namespace cairn {

// Sizes of the encoded tile payloads. file_overhead covers the rest of the file (index, keyframe
// rows, free pages). Ratios are zero if the map is empty.
struct MapSizes {
  double bytes_per_tile = 0.0;
  double bytes_per_landmark = 0.0;    // Whole payload, including descriptors.
  double bytes_per_descriptor = 0.0;  // Whole payload, including landmarks.
  double descriptors_per_landmark = 0.0;
  double file_overhead = 0.0;  // File size / payload size - 1.
};

MapSizes MeasureMapSizes(const MapInfo& info);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_EVALUATION_SIZE_H_
