#include "mapping/pairs/divide_polls.h"

#include <Eigen/Geometry>
#include <algorithm>
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

}  // namespace

Whereabouts::Whereabouts(const PhotoSet& set, const PairOptions& options) {
  for (const MappingPhoto& photo : set.photos) {
    x_in_ecef_.push_back(
        photo.gps ? std::optional(EcefFromGeodetic({photo.gps->lat_rad, photo.gps->lon_rad, 0.0}))
                  : std::nullopt);
    reach_m_.push_back(0.5 * options.max_distance_m +
                       photo.gps_accuracy_m.value_or(options.default_accuracy_m));
  }
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
