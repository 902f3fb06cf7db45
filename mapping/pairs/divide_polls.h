// Divides the search for pairs by places, so that its time is linear in the length of a walk.
#ifndef CAIRN_MAPPING_PAIRS_DIVIDE_POLLS_H_
#define CAIRN_MAPPING_PAIRS_DIVIDE_POLLS_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mapping/pairs/find_pairs.h"
#include "mapping/photo_set.h"

namespace cairn {

// Where photos may be, for the question whether two can show the same. A photo may meet those
// within PairOptions::max_distance_m, and the eight nearest within 500 m: a survey from the air has
// lanes farther apart, and a position may be wrong. Takes n log n in the number of photos along a
// line.
class Whereabouts {
 public:
  Whereabouts(const PhotoSet& set, const PairOptions& options);

  bool MayMeet(int a, int b) const {
    return !x_in_ecef_[a] || !x_in_ecef_[b] ||
           (*x_in_ecef_[a] - *x_in_ecef_[b]).norm() <= reach_m_[a] + reach_m_[b];
  }
  const std::optional<Eigen::Vector3d>& XInEcef(int photo) const { return x_in_ecef_[photo]; }
  // Two photos may meet within the sum of their reaches.
  double ReachM(int photo) const { return reach_m_[photo]; }

 private:
  std::vector<std::optional<Eigen::Vector3d>> x_in_ecef_;  // On the ellipsoid.
  std::vector<double> reach_m_;
};

// Photos that choose their partners together, and those that they may choose. Both ascend.
struct Poll {
  std::vector<int> photos;
  std::vector<int> candidates;
};

// Returns polls in which each photo of the set chooses once. A poll is halved across its longest
// extent as long as the halves take less time than the whole: some hundred photos, or all that are
// at one place. Photos without a position are candidates everywhere and choose among all. Time
// n log n in the number of photos, and linear in the candidates.
std::vector<Poll> DividePolls(const Whereabouts& whereabouts, int num_photos);

}  // namespace cairn

#endif  // CAIRN_MAPPING_PAIRS_DIVIDE_POLLS_H_
