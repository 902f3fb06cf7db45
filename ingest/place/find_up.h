// Decides which way is up in a reconstruction. Private to ingest/place.
#ifndef CAIRN_INGEST_PLACE_FIND_UP_H_
#define CAIRN_INGEST_PLACE_FIND_UP_H_

#include <Eigen/Core>

#include "ingest/place/up_evidence.h"

namespace cairn {

struct UpChoice {
  Eigen::Vector3d up_in_world = Eigen::Vector3d::UnitZ();
  UpScore score;
  Eigen::Vector3d next_in_world = Eigen::Vector3d::UnitZ();  // The next best of another kind.
  UpScore next_score;

  // How many times as likely as the next best.
  double Odds() const;
};

// Climbs from the axes of all cameras, from the up of the loose similarity, and from directions
// around the line of the walk. Directions within 25 degrees of each other are of one kind.
// Deterministic.
UpChoice FindUp(const UpEvidence& evidence);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_FIND_UP_H_
