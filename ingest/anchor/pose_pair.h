// A photo that the map recognizes.
#ifndef CAIRN_INGEST_ANCHOR_POSE_PAIR_H_
#define CAIRN_INGEST_ANCHOR_POSE_PAIR_H_

#include "core/rigid3.h"

namespace cairn {

// One camera, placed by its session and by the map.
struct PosePair {
  Rigid3d cam_from_ecef;         // By the session.
  Rigid3d cam_from_ecef_in_map;  // By the map.
  // Of the pose by the map: radii that contain 68 %; 0: unknown.
  double accuracy_m = 0.0;
  double accuracy_rad = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_ANCHOR_POSE_PAIR_H_
