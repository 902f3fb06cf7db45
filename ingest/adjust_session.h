// Adjusts a session together with the landmarks of the map that it sees. Private to ingest.
#ifndef CAIRN_INGEST_ADJUST_SESSION_H_
#define CAIRN_INGEST_ADJUST_SESSION_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/adjust/adjust.h"
#include "core/scene/reconstruction.h"
#include "ingest/tiles/placed_session.h"

namespace cairn {

struct JointAdjustment {
  int num_shared = 0;            // Landmarks of the session whose place the map told; 0: not run.
  int64_t num_observations = 0;  // That fit.
  double rms_px = 0.0;           // Of their errors.
  double largest_move_m = 0.0;   // Of a camera.
};

// Adjusts the cameras of the session and its landmarks to each other (core/adjust), with intrinsics
// as they are. A landmark whose place in `known_in_ecef` (parallel to the session's landmarks) is
// set stands there and does not move: so the session bends to the map in all that its photos tell.
// Does nothing if fewer than 20 landmarks are known: a few say less than the poses that were
// answered. If the solver fails, the session stays as it was. Deterministic. Takes linear time in
// the observations, apart from a sparse factorization.
JointAdjustment AdjustSession(const Reconstruction& reconstruction,
                              const std::vector<std::optional<Eigen::Vector3d>>& known_in_ecef,
                              int num_threads, PlacedSession* session,
                              const AdjustProgress& progress = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_ADJUST_SESSION_H_
