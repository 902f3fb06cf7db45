// Lets the photos that see a draft join it, round by round.
#ifndef CAIRN_MAPPING_GROWTH_GROW_DRAFT_H_
#define CAIRN_MAPPING_GROWTH_GROW_DRAFT_H_

#include <functional>
#include <vector>

#include "mapping/growth/draft.h"
#include "mapping/growth/grow_segments.h"
#include "mapping/growth/growth_scene.h"

namespace cairn {

// A draft of more photos is adjusted as a whole only when nothing joins it any more. Until then,
// what joined is adjusted together with what it is linked with: the rest does not change by it, and
// the time of an adjustment grows faster than the number of photos. Smaller drafts, whose cameras
// may still be guesses, are adjusted as a whole each time.
inline constexpr int kManyPhotos = 200;

// Receives the number of photos of a draft after each round.
using DraftProgress = std::function<void(int num_photos)>;

// Photos whose verdict is not kInSegment join the draft in rounds until none joins any more; then
// the draft is adjusted and what does not fit leaves it. Verdicts say why photos are not in the
// draft; those of its own photos are of no meaning until a segment takes them.
void GrowDraft(const GrowthScene& scene, const DraftProgress& progress, Draft* draft,
               std::vector<PhotoVerdict>* verdicts);

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_GROW_DRAFT_H_
