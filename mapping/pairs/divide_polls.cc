#include "mapping/pairs/divide_polls.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "core/geodesy.h"
#include "engine/index/index_options.h"

namespace cairn {
namespace {

// Comparisons of descriptors, in those of one voter a photo. Each voter is compared with the words
// of the lists, once to enter a list and once to vote, and then with the members of the lists that
// it probes. The training of the words takes the same whatever the poll.
double CostOf(const Poll& poll) {
  const InvertedListsOptions lists;
  constexpr double kSamplesPerWord = 32.0;
  constexpr double kVotersOfPhoto = 1000.0;
  const double num_photos = static_cast<double>(poll.photos.size());
  const double num_candidates = static_cast<double>(poll.candidates.size());
  const double training =
      kSamplesPerWord * lists.num_lists / kVotersOfPhoto * lists.num_lists * lists.num_iterations;
  const double probed = num_candidates * kVotersOfPhoto * lists.num_probes / lists.num_lists;
  return training + num_candidates * lists.num_lists + num_photos * (lists.num_lists + probed);
}

// Of photos with positions.
Eigen::AlignedBox3d BoxOf(const Whereabouts& whereabouts, const std::vector<int>& photos) {
  Eigen::AlignedBox3d box;
  for (const int photo : photos) {
    box.extend(*whereabouts.XInEcef(photo));
  }
  return box;
}

// Those of `candidates` that one of the photos may meet, and perhaps some more.
std::vector<int> WithinReach(const Whereabouts& whereabouts, const std::vector<int>& photos,
                             const std::vector<int>& candidates) {
  const Eigen::AlignedBox3d box = BoxOf(whereabouts, photos);
  double reach_m = 0.0;
  for (const int photo : photos) {
    reach_m = std::max(reach_m, whereabouts.ReachM(photo));
  }
  std::vector<int> within;
  for (const int candidate : candidates) {
    const auto& x_in_ecef = whereabouts.XInEcef(candidate);
    if (!x_in_ecef || box.exteriorDistance(*x_in_ecef) <= reach_m + whereabouts.ReachM(candidate)) {
      within.push_back(candidate);
    }
  }
  return within;
}

// The halves of a poll whose photos have positions, beside each other.
std::pair<Poll, Poll> Halve(const Whereabouts& whereabouts, const Poll& poll) {
  Eigen::Index axis = 0;
  BoxOf(whereabouts, poll.photos).sizes().maxCoeff(&axis);
  std::vector<int> order = poll.photos;
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
  const auto key = [&](int photo) { return std::pair((*whereabouts.XInEcef(photo))[axis], photo); };
  std::nth_element(order.begin(), middle, order.end(),
                   [&](int p, int q) { return key(p) < key(q); });
  const auto half = [&](std::vector<int> photos) {
    std::sort(photos.begin(), photos.end());
    std::vector<int> candidates = WithinReach(whereabouts, photos, poll.candidates);
    return Poll{std::move(photos), std::move(candidates)};
  };
  return {half({order.begin(), middle}), half({middle, order.end()})};
}

void Divide(const Whereabouts& whereabouts, Poll poll, std::vector<Poll>* polls) {
  if (poll.photos.size() >= 2) {
    auto [first, second] = Halve(whereabouts, poll);
    if (CostOf(first) + CostOf(second) < CostOf(poll)) {
      Divide(whereabouts, std::move(first), polls);
      Divide(whereabouts, std::move(second), polls);
      return;
    }
  }
  polls->push_back(std::move(poll));
}

// A photo of an aerial survey has as many neighbors in its lane and in those beside it.
constexpr size_t kMinNeighbors = 8;
// Two photos from the ground or from a drone that are twice as far apart show nothing in common.
constexpr double kMaxNeighborM = 500.0;

// Keeps the least distances of a photo from others.
class NearestDistances {
 public:
  void Add(double distance_m) {
    const auto at = std::upper_bound(ascending_m_.begin(), ascending_m_.end(), distance_m);
    ascending_m_.insert(at, distance_m);
    ascending_m_.resize(std::min(ascending_m_.size(), kMinNeighbors));
  }
  // True if no distance of `least_m` or more can change the result.
  bool IsFinal(double least_m) const {
    return ascending_m_.size() == kMinNeighbors && least_m >= ascending_m_.back();
  }
  double FarthestM() const { return ascending_m_.empty() ? 0.0 : ascending_m_.back(); }

 private:
  std::vector<double> ascending_m_;
};

// Raises the reach of photos so that it includes their nearest ones. `placed` have positions.
void ReachNearest(const std::vector<std::optional<Eigen::Vector3d>>& x_in_ecef,
                  std::vector<int> placed, std::vector<double>* reach_m) {
  Eigen::AlignedBox3d box;
  for (const int photo : placed) {
    box.extend(*x_in_ecef[photo]);
  }
  Eigen::Index axis = 0;
  if (!placed.empty()) {
    box.sizes().maxCoeff(&axis);
  }
  const auto along = [&](int photo) { return (*x_in_ecef[photo])[axis]; };
  std::sort(placed.begin(), placed.end(),
            [&](int p, int q) { return std::pair(along(p), p) < std::pair(along(q), q); });
  for (size_t i = 0; i < placed.size(); ++i) {
    NearestDistances nearest;
    // Looks at the photos before and after it along the axis, the nearer one first.
    size_t before = i, after = i + 1;
    while (before > 0 || after < placed.size()) {
      const double infinity = std::numeric_limits<double>::infinity();
      const double before_m = before > 0 ? along(placed[i]) - along(placed[before - 1]) : infinity;
      const double after_m =
          after < placed.size() ? along(placed[after]) - along(placed[i]) : infinity;
      if (nearest.IsFinal(std::min(before_m, after_m))) {
        break;
      }
      const int other = placed[before_m <= after_m ? --before : after++];
      nearest.Add((*x_in_ecef[placed[i]] - *x_in_ecef[other]).norm());
    }
    double& reach = (*reach_m)[placed[i]];
    reach = std::max(reach, std::min(nearest.FarthestM(), kMaxNeighborM));
  }
}

}  // namespace

Whereabouts::Whereabouts(const PhotoSet& set, const PairOptions& options) {
  std::vector<int> placed;
  for (const MappingPhoto& photo : set.photos) {
    x_in_ecef_.push_back(
        photo.gps ? std::optional(EcefFromGeodetic({photo.gps->lat_rad, photo.gps->lon_rad, 0.0}))
                  : std::nullopt);
    reach_m_.push_back(0.5 * options.max_distance_m +
                       photo.gps_accuracy_m.value_or(options.default_accuracy_m));
    if (photo.gps) {
      placed.push_back(static_cast<int>(x_in_ecef_.size()) - 1);
    }
  }
  ReachNearest(x_in_ecef_, std::move(placed), &reach_m_);
}

std::vector<Poll> DividePolls(const Whereabouts& whereabouts, int num_photos) {
  Poll placed, unplaced;
  for (int photo = 0; photo < num_photos; ++photo) {
    (whereabouts.XInEcef(photo) ? placed : unplaced).photos.push_back(photo);
    placed.candidates.push_back(photo);
  }
  unplaced.candidates = placed.candidates;
  std::vector<Poll> polls;
  if (!placed.photos.empty()) {
    Divide(whereabouts, std::move(placed), &polls);
  }
  if (!unplaced.photos.empty()) {
    polls.push_back(std::move(unplaced));
  }
  return polls;
}

}  // namespace cairn
