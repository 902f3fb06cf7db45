// Keeps answers before the alignment until enough of them agree.
#ifndef CAIRN_FUSION_MAP_UPDATES_ALIGNMENT_CANDIDATES_H_
#define CAIRN_FUSION_MAP_UPDATES_ALIGNMENT_CANDIDATES_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "fusion/map_updates/map_match.h"

namespace cairn::fusion {

struct AlignmentCandidate {
  int64_t frame_id = 0;       // The queried frame.
  Rigid3d global_from_local;  // Leveled by Level().
  std::vector<MapMatch> matches;
};

// Holds the last five answers before the alignment. The caller keeps the clone of a candidate's
// frame and reserves the frame's observations until Add or Release returns the frame. Not
// thread-safe.
class AlignmentCandidates {
 public:
  bool empty() const { return candidates_.empty(); }

  // Returns whether a candidate belongs to this frame.
  bool HasFrame(int64_t frame_id) const;

  // Adds a candidate. If the oldest candidate was dropped for it, returns that one's frame.
  std::optional<int64_t> Add(AlignmentCandidate candidate);

  // Returns the largest set that agrees at `x_in_local` (LargestAgreeingSet), oldest first. Returns
  // an empty set if fewer than three agree. The pointers are valid until the next
  // call that is not const.
  std::vector<const AlignmentCandidate*> Agreeing(const Eigen::Vector3d& x_in_local) const;

  // Drops all candidates and returns their frames.
  std::vector<int64_t> Release();

 private:
  std::vector<AlignmentCandidate> candidates_;  // Oldest first.
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_ALIGNMENT_CANDIDATES_H_
