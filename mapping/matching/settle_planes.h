// Decides, of the two stories that two photos of a plane allow, by what other photos say.
#ifndef CAIRN_MAPPING_MATCHING_SETTLE_PLANES_H_
#define CAIRN_MAPPING_MATCHING_SETTLE_PLANES_H_

#include <vector>

#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn {

// Two views of one plane each have a twin (PlaneTwin) that may fit as well. Under the right
// stories, all two views of a photo see the plane under one normal; the wrong ones depend on the
// direction and the length of the baseline. Each two view takes the story with which more of the
// two views of its photos agree. Deterministic, on any number of threads.
void SettlePlanes(const PhotoSet& set, int num_threads, std::vector<TwoView>* views);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_SETTLE_PLANES_H_
