#include "ingest/anchor/consistent_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "core/radius68.h"
#include "core/statistics.h"
#include "ingest/anchor/frame_groups.h"

namespace cairn {
namespace {

constexpr double kOnePlaceM = 0.3;  // A walker takes 0.2 s.
constexpr double kWindowM = 60.0;

// A frame's two poses, and the variances of their difference.
struct Frame {
  Rigid3d ecef_from_cam, in_map;
  double var_m2 = 0.0, var_rad2 = 0.0;
  Eigen::Vector3d center_in_ecef;  // By the session in its own size, as the rest of it is weighed.
};

// The session is made `scale` times as large, about the first frame.
std::vector<Frame> FramesOf(const std::vector<PosePair>& pairs, const ConsistencyOptions& options,
                            double scale) {
  const Eigen::Vector3d fixed = pairs.front().cam_from_ecef.Inverse().translation;
  std::vector<Frame> frames;
  for (const PosePair& pair : pairs) {
    const Rigid3d ecef_from_cam = pair.cam_from_ecef.Inverse();
    frames.push_back(
        {{ecef_from_cam.rotation, fixed + scale * (ecef_from_cam.translation - fixed)},
         pair.cam_from_ecef_in_map.Inverse(),
         std::pow(options.position_sigma_m, 2) + std::pow(pair.accuracy_m / kRadius68PerSigma3d, 2),
         std::pow(options.rotation_sigma_rad, 2) +
             std::pow(pair.accuracy_rad / kRadius68PerSigma3d, 2),
         ecef_from_cam.translation});
  }
  return frames;
}

double DistanceM(const Frame& a, const Frame& b) {
  return (a.ecef_from_cam.translation - b.ecef_from_cam.translation).norm();
}

bool AreNear(const Frame& a, const Frame& b) { return DistanceM(a, b) <= kWindowM; }

// The squared difference of b's position as a sees it, in standard deviations, if the session is
// `scale` times as large.
double PositionChiSq(const Frame& a, const Frame& b, const ConsistencyOptions& options,
                     double scale) {
  const Eigen::Vector3d by_session =
      scale * (a.ecef_from_cam.rotation.conjugate() *
               (b.ecef_from_cam.translation - a.ecef_from_cam.translation));
  const Eigen::Vector3d by_map =
      a.in_map.rotation.conjugate() * (b.in_map.translation - a.in_map.translation);
  const Eigen::Vector3d difference = by_map - by_session;
  const double distance_m = by_session.norm();
  const double var_m2 = a.var_m2 + b.var_m2 + std::pow(options.drift_share * distance_m, 2);
  const double along_m =
      distance_m > 0.0 ? difference.dot(by_session) / distance_m : difference.norm();
  const double across_sq_m2 = std::max(0.0, difference.squaredNorm() - along_m * along_m);
  return along_m * along_m / (var_m2 + std::pow(options.scale_sigma * distance_m, 2)) +
         across_sq_m2 / (var_m2 + a.var_rad2 * distance_m * distance_m);
}

bool AreConsistent(const Frame& a, const Frame& b, const ConsistencyOptions& options,
                   double scale = 1.0) {
  const double turned_rad =
      RotationAngleRad(a.ecef_from_cam.rotation.conjugate() * b.ecef_from_cam.rotation,
                       a.in_map.rotation.conjugate() * b.in_map.rotation);
  const double drift_rad = options.drift_rad * std::min(1.0, DistanceM(a, b) / kWindowM);
  const double chi_sq =
      turned_rad * turned_rad / (a.var_rad2 + b.var_rad2 + drift_rad * drift_rad) +
      std::min(PositionChiSq(a, b, options, scale), PositionChiSq(b, a, options, scale));
  return chi_sq <= options.max_chi_sq;
}

int PlacesAmong(std::span<const Eigen::Vector3d> centers, int limit) {
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3d& center : centers) {
    const bool is_new = std::none_of(places.begin(), places.end(), [&](const auto& place) {
      return (center - place).norm() <= kOnePlaceM;
    });
    if (is_new) {
      places.push_back(center);
      if (static_cast<int>(places.size()) == limit) {
        break;
      }
    }
  }
  return static_cast<int>(places.size());
}

double ExtentOf(std::span<const Eigen::Vector3d> centers) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& center : centers) {
    box.extend(center);
  }
  return box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
}

std::vector<Eigen::Vector3d> CentersOf(const std::vector<Frame>& frames,
                                       const std::vector<size_t>& set) {
  std::vector<Eigen::Vector3d> centers;
  for (const size_t i : set) {
    centers.push_back(frames[i].center_in_ecef);
  }
  return centers;
}

FrameSet Weigh(const std::vector<Frame>& frames, const std::vector<size_t>& set) {
  const std::vector<Eigen::Vector3d> centers = CentersOf(frames, set);
  const int num_frames = static_cast<int>(set.size());
  return {num_frames, PlacesAmong(centers, num_frames), ExtentOf(centers)};
}

// The groups of frames that agree with each other; first that of most places, then of most frames,
// then of the earliest frame.
std::vector<std::vector<size_t>> GroupsOf(const std::vector<Frame>& frames,
                                          const ConsistencyOptions& options) {
  std::vector<FramePair> pairs;
  for (size_t a = 0; a < frames.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      if (AreNear(frames[a], frames[b])) {
        pairs.push_back(
            {a, b, DistanceM(frames[a], frames[b]), AreConsistent(frames[a], frames[b], options)});
      }
    }
  }
  std::vector<std::vector<size_t>> groups = GroupFrames(frames.size(), std::move(pairs));
  const auto weight = [&](const std::vector<size_t>& group) {
    return std::pair(Weigh(frames, group).num_places, group.size());
  };
  std::stable_sort(groups.begin(), groups.end(),
                   [&](const auto& a, const auto& b) { return weight(a) > weight(b); });
  return groups;
}

bool AreNear(const std::vector<Frame>& frames, const std::vector<size_t>& as,
             const std::vector<size_t>& bs) {
  return std::any_of(as.begin(), as.end(), [&](size_t a) {
    return std::any_of(bs.begin(), bs.end(),
                       [&](size_t b) { return AreNear(frames[a], frames[b]); });
  });
}

// The size of the session by the map: the median over pairs of frames of a set that are at most
// `most_m` apart, and at least half of that, or of the extent of the set if that is less. Pairs
// closer than a meter tell nothing.
double ScaleBy(const std::vector<Frame>& frames, const std::vector<size_t>& set,
               double most_m = std::numeric_limits<double>::infinity()) {
  const double least_m = std::max(1.0, 0.5 * std::min(most_m, Weigh(frames, set).extent_m));
  std::vector<double> scales;
  for (const size_t i : set) {
    for (const size_t j : set) {
      const double by_session_m = DistanceM(frames[i], frames[j]);
      if (i < j && by_session_m >= least_m && by_session_m <= most_m) {
        scales.push_back((frames[i].in_map.translation - frames[j].in_map.translation).norm() /
                         by_session_m);
      }
    }
  }
  return scales.empty() ? 1.0 : Median(std::move(scales));
}

// The distance within which frames of a set follow each other without a gap.
double StepM(const std::vector<Frame>& frames, const std::vector<size_t>& set) {
  constexpr double kLeastM = 15.0;
  std::vector<double> nearest_m;
  for (const size_t i : set) {
    double least_m = std::numeric_limits<double>::infinity();
    for (const size_t j : set) {
      least_m = i == j ? least_m : std::min(least_m, DistanceM(frames[i], frames[j]));
    }
    nearest_m.push_back(least_m);
  }
  return std::max(kLeastM, 2.0 * Median(std::move(nearest_m)));
}

// The part of a set that has most frames and no gap.
std::vector<size_t> LargestRun(const std::vector<Frame>& frames, std::vector<size_t> set) {
  const double step_m = StepM(frames, set);
  std::vector<size_t> largest;
  while (set.size() > largest.size()) {
    std::vector<size_t> run = {set.back()};
    set.pop_back();
    for (size_t next = 0; next < run.size(); ++next) {
      const auto is_far = [&](size_t i) {
        return DistanceM(frames[i], frames[run[next]]) > step_m;
      };
      const auto near = std::stable_partition(set.begin(), set.end(), is_far);
      run.insert(run.end(), near, set.end());
      set.erase(near, set.end());
    }
    if (run.size() > largest.size()) {
      largest = std::move(run);
    }
  }
  return largest;
}

// The relative standard deviation of the size that frames over this extent tell.
double ScaleSigma(const ConsistencyOptions& options, double extent_m) {
  return std::min(options.scale_sigma,
                  options.drift_share + options.position_sigma_m / std::max(1.0, extent_m));
}

// Whether most pairs of a frame of the island and one of the winner are consistent. The winner
// tells the size of the session.
bool IsIslandOf(const std::vector<Frame>& frames, const std::vector<size_t>& island,
                const std::vector<size_t>& winner, ConsistencyOptions options) {
  const double scale = ScaleBy(frames, winner);
  options.scale_sigma = ScaleSigma(options, Weigh(frames, winner).extent_m);
  int64_t num_consistent = 0;
  for (const size_t i : island) {
    for (const size_t j : winner) {
      num_consistent += AreConsistent(frames[i], frames[j], options, scale) ? 1 : 0;
    }
  }
  return 2 * num_consistent > static_cast<int64_t>(island.size() * winner.size());
}

// What the groups of a session say together.
class Verdict {
 public:
  Verdict(const std::vector<Frame>& frames, const ConsistencyOptions& options)
      : frames_(frames), options_(options), groups_(GroupsOf(frames, options)) {}

  ConsistentFrames Reach() {
    accepted_ = groups_.front();
    for (size_t k = 1; k < groups_.size(); ++k) {
      if (groups_[k].size() > 1) {
        Settle(groups_[k]);
      }
    }
    std::sort(accepted_.begin(), accepted_.end());
    result_.winner = Weigh(frames_, accepted_);
    result_.agrees = Flags(accepted_);
    result_.is_rival = Flags(rival_);
    return std::move(result_);
  }

 private:
  std::vector<bool> Flags(const std::vector<size_t>& set) const {
    std::vector<bool> flags(frames_.size(), false);
    for (const size_t i : set) {
      flags[i] = true;
    }
    return flags;
  }

  // Accepts the group as an island, notes that it is a rival, or passes over it.
  void Settle(const std::vector<size_t>& group) {
    const FrameSet weight = Weigh(frames_, group);
    const bool is_apart = !AreNear(frames_, group, accepted_);
    if (is_apart && IsIslandOf(frames_, group, groups_.front(), options_)) {
      if (weight.num_places >= kIslandPlaces && !IsContested(group, weight)) {
        accepted_.insert(accepted_.end(), group.begin(), group.end());
      }
      return;
    }
    if (weight.num_places > result_.rival.num_places) {
      result_.rival = weight;
      rival_ = group;
    }
    result_.rival_is_apart |= is_apart && 2 * weight.num_places >= kIslandPlaces;
  }

  // Whether another group of half as many places stands near this one.
  bool IsContested(const std::vector<size_t>& group, const FrameSet& weight) const {
    return std::any_of(groups_.begin(), groups_.end(), [&](const std::vector<size_t>& other) {
      return &other != &group && 2 * Weigh(frames_, other).num_places >= weight.num_places &&
             AreNear(frames_, other, group);
    });
  }

  const std::vector<Frame>& frames_;
  const ConsistencyOptions& options_;
  const std::vector<std::vector<size_t>> groups_;
  std::vector<size_t> accepted_, rival_;
  ConsistentFrames result_;
};

// The frames that agree if each pair may have a size of its own.
ConsistentFrames SearchInAnySize(const std::vector<PosePair>& pairs,
                                 const std::vector<Frame>& frames,
                                 const ConsistencyOptions& options) {
  ConsistentFrames result = Verdict(frames, options).Reach();
  if (2 * result.winner.num_frames < static_cast<int>(pairs.size())) {
    std::vector<size_t> all(frames.size());
    std::iota(all.begin(), all.end(), 0);
    const std::vector<Frame> resized = FramesOf(pairs, options, ScaleBy(frames, all));
    ConsistentFrames other = Verdict(resized, options).Reach();
    if (other.winner.num_places > result.winner.num_places) {
      result = std::move(other);
    }
  }
  return result;
}

std::vector<Eigen::Vector3d> CentersOf(const std::vector<Rigid3d>& cam_from_ecef) {
  std::vector<Eigen::Vector3d> centers;
  for (const Rigid3d& pose : cam_from_ecef) {
    centers.push_back(pose.Inverse().translation);
  }
  return centers;
}

}  // namespace

ConsistentFrames FindConsistentFrames(const std::vector<PosePair>& pairs,
                                      const ConsistencyOptions& options) {
  if (pairs.empty()) {
    return {};
  }
  const std::vector<Frame> frames = FramesOf(pairs, options, 1.0);
  const std::vector<bool> agrees = SearchInAnySize(pairs, frames, options).agrees;
  std::vector<size_t> agreeing;
  for (size_t i = 0; i < agrees.size(); ++i) {
    if (agrees[i]) {
      agreeing.push_back(i);
    }
  }
  // A size for each pair would excuse runs that are moved along the way, and so would a size that
  // pairs across a gap tell, if what lies beyond the gap is moved.
  const double extent_m = std::min(kWindowM, Weigh(frames, agreeing).extent_m);
  std::vector<size_t> run = LargestRun(frames, agreeing);
  if (Weigh(frames, run).extent_m < 0.5 * extent_m) {
    run = agreeing;
  }
  ConsistencyOptions sized = options;
  sized.scale_sigma = ScaleSigma(options, std::min(kWindowM, Weigh(frames, run).extent_m));
  const std::vector<Frame> resized = FramesOf(pairs, sized, ScaleBy(frames, run, kWindowM));
  return Verdict(resized, sized).Reach();
}

int CountPlaces(const std::vector<Rigid3d>& cam_from_ecef, int limit) {
  return PlacesAmong(CentersOf(cam_from_ecef), limit);
}

double ExtentM(const std::vector<Rigid3d>& cam_from_ecef) {
  return ExtentOf(CentersOf(cam_from_ecef));
}

int PlacesNeeded(const AnchorEvidence& evidence) {
  constexpr int kLeastPlaces = 3;
  return std::min(kIslandPlaces, std::max(kLeastPlaces, (evidence.session.num_places + 1) / 2));
}

double ExtentNeededM(const AnchorEvidence& evidence) {
  return std::min(10.0, 0.5 * evidence.session.extent_m);
}

bool IsAnchored(const AnchorEvidence& evidence) {
  return evidence.winner.num_places >= PlacesNeeded(evidence) &&
         evidence.winner.extent_m >= ExtentNeededM(evidence) &&
         5 * evidence.winner.num_frames >= evidence.num_answers &&
         2 * evidence.rival.num_places < evidence.winner.num_places && !evidence.rival_is_apart;
}

}  // namespace cairn
