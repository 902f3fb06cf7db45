#include "lab/experiments/measure/evaluation_size.h"

#include <cstdint>

namespace cairn {
namespace {

double Ratio(int64_t numerator, int64_t denominator) {
  return denominator == 0 ? 0.0 : static_cast<double>(numerator) / static_cast<double>(denominator);
}

}  // namespace

MapSizes MeasureMapSizes(const MapInfo& info) {
  MapSizes sizes;
  sizes.bytes_per_tile = Ratio(info.payload_bytes, info.num_tiles);
  sizes.bytes_per_landmark = Ratio(info.payload_bytes, info.num_landmarks);
  sizes.bytes_per_descriptor = Ratio(info.payload_bytes, info.num_descriptors);
  sizes.descriptors_per_landmark = Ratio(info.num_descriptors, info.num_landmarks);
  sizes.file_overhead = Ratio(info.file_bytes - info.payload_bytes, info.payload_bytes);
  return sizes;
}

}  // namespace cairn
