// Selects the pairs of photos that are worth matching.
#ifndef CAIRN_MAPPING_PAIRS_FIND_PAIRS_H_
#define CAIRN_MAPPING_PAIRS_FIND_PAIRS_H_

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "mapping/photo_set.h"

namespace cairn {

struct PairOptions {
  // Photos that each photo chooses; others may choose it, too.
  int max_partners = 14;
  // A set of at most this many photos is matched completely.
  int max_exhaustive = 12;
  // Keypoints of a photo that vote, the largest first: they are seen from farther away.
  int max_voters = 1000;
  // Photos of one place whose voters are compared with those of a photo at once. Ten minutes of a
  // phone's burst are more, and to compare all with all would take hours.
  int max_panel = 1000;
  // Images of this many nearest descriptors of other photos get a vote.
  int neighbors_per_voter = 4;
  // Photos with a position choose those within this distance plus both accuracies, and the nearest.
  double max_distance_m = 30.0;
  // Accuracy of a position that does not state it: a phone's in a street.
  double default_accuracy_m = 15.0;
  int num_threads = 1;  // The result does not depend on it.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Returns pairs (a, b) with a < b, ascending, each once. The voting descriptors go into indices
// (the shipped codebook), one for each place (DividePolls); each votes for the photos of its
// nearest neighbors, and each photo chooses those with the most votes.
//
// Of a place with more than max_panel photos, a panel from all over it comes into the first index.
// A photo that looks like enough of the panel chooses among the panel alone. The others go on with
// a panel of those that are left; photos that chose are not asked any more. Time is therefore
// linear in the number of photos if these have positions and spread over ground, and if they show
// one place many times: about 10 ms a photo and panel. Memory beside the set is 16 kB a photo and
// an index of one panel. `progress` receives photos done and their number. Throws Error(kBadInput)
// for descriptors that are not those of the shipped codebook.
std::vector<std::pair<int, int>> FindPairs(
    const PhotoSet& set, const PairOptions& options,
    const std::function<void(int done, int total)>& progress = {});

}  // namespace cairn

#endif  // CAIRN_MAPPING_PAIRS_FIND_PAIRS_H_
