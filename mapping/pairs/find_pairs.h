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
// nearest neighbors, and each photo chooses those with the most votes. Takes time linear in the
// number of photos if these have positions and spread over ground; of photos at one place, or
// without positions, a search takes about 10 ms a photo among 1,000 photos, and grows with their
// number. `progress` receives photos done and their number.
std::vector<std::pair<int, int>> FindPairs(
    const PhotoSet& set, const PairOptions& options,
    const std::function<void(int done, int total)>& progress = {});

}  // namespace cairn

#endif  // CAIRN_MAPPING_PAIRS_FIND_PAIRS_H_
