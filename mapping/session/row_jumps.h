// Positions that leave the row of photos in which they were taken.
#ifndef CAIRN_MAPPING_SESSION_ROW_JUMPS_H_
#define CAIRN_MAPPING_SESSION_ROW_JUMPS_H_

#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn {

// Takes positions from photos, in the order of the set, if a walk cannot have them:
// - a position far from those of the six photos around it, which are near each other;
// - a run of positions that jumps away and back, if the runs before and after it are longer;
// - the same position for the first or the last photos, far from the next: a receiver that had not
//   found its place yet;
// - all runs but one that are parted by jumps where the photos before and after show the same: runs
//   are misplaced as a whole. The run nearest to the photos of the set keeps its positions.
// Then the same for heights; where these are wrong, the photo has a position without a height.
//
// "Far" is five times the usual distance there, or the accuracy if that is more, which for heights
// is twice that of the position. Photos in no order keep their positions, because none is near the
// next. A photo that loses a position that was right after all, such as that of another walk
// between two photos of this one, is compared with all others. The placement, which knows all
// positions, finds out by itself which agree. `accuracy_m` is that of positions that state none.
// Matches six pairs a jump.
void DropJumps(double accuracy_m, const TwoViewOptions& options, PhotoSet* set);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_ROW_JUMPS_H_
