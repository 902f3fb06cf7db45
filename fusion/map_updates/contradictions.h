// Decides when answers that contradict an alignment end it.
#ifndef CAIRN_FUSION_MAP_UPDATES_CONTRADICTIONS_H_
#define CAIRN_FUSION_MAP_UPDATES_CONTRADICTIONS_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/rigid3.h"

namespace cairn::fusion {

// The filter drops an alignment after this many consecutive answers that contradict the alignment
// and agree with one another. These answers must span at least this much time, seconds.
inline constexpr int kMinContradictions = 5;
inline constexpr double kMinContradictionSpanS = 3.0;

// Collects successive answers that contradict the state and agree with one another. A single one of
// them may be wrong; if many agree, the alignment is wrong. Not thread-safe.
class Contradictions {
 public:
  // Adds an answer that contradicts the state. `timestamp_ns` is the time of its frame,
  // `global_from_local` the alignment it implies, and `x_in_local` the device's position, where
  // agreement is tested. Drops the answers up to the last one that disagrees with this one. Returns
  // true and drops all answers once there are kMinContradictions that span kMinContradictionSpanS.
  bool Add(int64_t timestamp_ns, const Rigid3d& global_from_local,
           const Eigen::Vector3d& x_in_local);

  // Drops all answers. To be called when an answer agrees with the state.
  void Clear() { contradictions_.clear(); }

 private:
  struct Contradiction {
    int64_t timestamp_ns;
    Rigid3d global_from_local;
  };

  std::vector<Contradiction> contradictions_;  // In order of arrival.
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_CONTRADICTIONS_H_
