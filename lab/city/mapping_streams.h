// Random streams that simulated_mapping.cc and chunk_maker.cc share. Private to the two.
#ifndef CAIRN_LAB_CITY_MAPPING_STREAMS_H_
#define CAIRN_LAB_CITY_MAPPING_STREAMS_H_

#include <Eigen/Core>
#include <cstdint>

#include "core/geodesy.h"
#include "core/tile_id.h"
#include "lab/city/city.h"

namespace cairn {

// Streams of random numbers that must stay separate.
enum MappingStream : uint64_t {
  kDeformationStream = 0x401,
  kDriftStream,
  kLaneStream,
  kKeyframeStream,
  kImageStream,
  kJoinStream,
  kTrackStream,
  kPoseNoiseStream,
  kGpsStream,
  kWrongStream,
  kClutterStream,
};

inline TileId TileAt(const City& city, const Eigen::Vector3d& x_in_site) {
  return TileId::Containing(GeodeticFromEcef(city.ecef_from_site() * x_in_site));
}

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_MAPPING_STREAMS_H_
