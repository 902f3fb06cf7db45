#include "engine/voting/pose_voting.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/angles.h"
#include "core/check.h"
#include "core/features.h"
#include "engine/voting/candidate_support.h"
#include "engine/voting/ray_arrays.h"
#include "engine/voting/trace_rays.h"
#include "engine/voting/vote_accumulator.h"
#include "engine/voting/vote_ray.h"

namespace cairn {
namespace {

// Returns the grid of camera positions: the region, limited to positions from which a landmark can
// be seen.
VoteGrid MakeGrid(const std::vector<VoteRay>& rays, const SearchRegion& region,
                  const VotingOptions& options) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const VoteRay& ray : rays) {
    const Eigen::Vector3d reach =
        Eigen::Vector3d::Constant(ray.max_distance_m + ray.origin_in_level.norm());
    low = low.cwiseMin(ray.x_in_anchor - reach);
    high = high.cwiseMax(ray.x_in_anchor + reach);
  }
  const Eigen::Vector2d center = region.prior_xy_in_anchor;
  const Eigen::Vector2d radius = Eigen::Vector2d::Constant(region.radius_m);
  low.head<2>() = low.head<2>().cwiseMax(center - radius);
  high.head<2>() = high.head<2>().cwiseMin(center + radius);
  low.z() = std::max(low.z(), region.min_z_m);
  high.z() = std::min(high.z(), region.max_z_m);
  const double cell_z_m = options.filter == OutlierFilter::kVoting3d
                              ? std::max(options.cell_z_m, 1.001 * (high.z() - low.z()))
                              : options.cell_z_m;
  return VoteGrid(low, high, {options.cell_xy_m, options.cell_xy_m, cell_z_m});
}

// The data that all votes of a query share.
struct Ballot {
  RayArrays<float> rays;
  VoteGrid grid;
  double radius_m = 0.0;
  double min_cosine = 0.0;
  int num_yaws = 0;
};

constexpr int kPeaksPerCandidate = 32;  // Most peaks are neighbors of a few maxima.

struct YawRangePeaks {
  std::vector<VotePeak> peaks;  // The best peaks, best first.
  int64_t num_votes = 0;
};

// Finds the peaks between yaw bins `begin` and `end`. Peak i sums bins i and i + 1 along each of
// the four axes, so the bin after the range is filled as well. Returns fewer peaks if `should_stop`
// returns true.
YawRangePeaks FindPeaksInRange(const Ballot& ballot, int begin, int end,
                               const VotingOptions& options, const StopFunction& should_stop) {
  VoteSegments segments(ballot.rays.padded_size());
  VoteSlice slice(ballot.grid);
  PeakCollector peaks(kPeaksPerCandidate * options.max_candidates,
                      static_cast<int>(std::ceil(options.min_score)));
  YawRangePeaks result;
  std::vector<uint16_t> first, previous, current;
  const auto fill = [&](int yaw_idx, std::vector<uint16_t>* smoothed) {
    const double yaw_rad = 2.0 * kPi * yaw_idx / ballot.num_yaws;
    const TraceFrame frame(ballot.grid, ballot.rays.center_in_anchor, ballot.radius_m,
                           ballot.min_cosine, yaw_rad);
    TraceRays(ballot.rays, frame, &segments);
    const int64_t num_votes = slice.Vote(segments, ballot.rays.voters);
    slice.SmoothAndClear(smoothed);
    return num_votes;
  };
  const bool is_full_circle = end - begin == ballot.num_yaws;
  result.num_votes += fill(begin, &previous);
  if (is_full_circle) {
    first = previous;
  }
  for (int yaw_idx = begin + 1; yaw_idx < end; ++yaw_idx) {
    if (should_stop && should_stop()) {
      return result;
    }
    result.num_votes += fill(yaw_idx, &current);
    peaks.Offer(yaw_idx - 1, previous, current);
    std::swap(previous, current);
  }
  if (is_full_circle) {
    current = std::move(first);
  } else {
    fill(end % ballot.num_yaws, &current);  // The votes of this bin count in another range.
  }
  peaks.Offer(end - 1, previous, current);
  result.peaks = peaks.TakeSorted();
  return result;
}

struct Peaks {
  std::vector<VotePeak> best;  // Best first.
  int64_t num_votes = 0;
};

// Finds the cells with the most votes. Ranges of yaw are independent, but one slice per range is
// filled twice, so there are at most as many ranges as threads.
Peaks FindPeaks(const Ballot& ballot, const VotingOptions& options, SharedWorkers* workers,
                const StopFunction& should_stop) {
  const int num_ranges =
      std::clamp(workers != nullptr ? workers->NumFree() : 1, 1, ballot.num_yaws / 2);
  std::vector<YawRangePeaks> ranges(num_ranges);
  ForEachStep(workers, num_ranges, [&](int i) {
    ranges[i] = FindPeaksInRange(ballot, i * ballot.num_yaws / num_ranges,
                                 (i + 1) * ballot.num_yaws / num_ranges, options, should_stop);
  });
  Peaks peaks;
  for (const YawRangePeaks& range : ranges) {
    peaks.num_votes += range.num_votes;
    peaks.best.insert(peaks.best.end(), range.peaks.begin(), range.peaks.end());
  }
  std::sort(peaks.best.begin(), peaks.best.end(), IsBetterPeak);
  peaks.best.resize(std::min(peaks.best.size(), static_cast<size_t>(kPeaksPerCandidate) *
                                                    static_cast<size_t>(options.max_candidates)));
  return peaks;
}

// Returns the pose in the middle of the cells that a peak sums.
PoseCandidate CandidateAt(const VotePeak& peak, const VoteGrid& grid, int num_yaws) {
  const auto strides = grid.strides();
  const Eigen::Vector3d corner(peak.cell_idx % strides[1] + 1,
                               peak.cell_idx % strides[2] / strides[1] + 1,
                               peak.cell_idx / strides[2] + 1);
  PoseCandidate candidate;
  candidate.center_in_anchor = grid.FromCells(corner);
  candidate.yaw_rad = WrapAngleRad(2.0 * kPi * (peak.yaw_idx + 0.5) / num_yaws);
  candidate.score = peak.sum;
  return candidate;
}

// Returns true if two candidates are neighbors in the accumulator.
bool IsNear(const PoseCandidate& a, const PoseCandidate& b, const VoteGrid& grid,
            double yaw_step_rad) {
  constexpr double kNumCells = 2.5;
  const Eigen::Vector3d offset =
      (a.center_in_anchor - b.center_in_anchor).cwiseQuotient(grid.cell_m());
  return offset.cwiseAbs().maxCoeff() < kNumCells &&
         std::abs(WrapAngleRad(a.yaw_rad - b.yaw_rad)) < kNumCells * yaw_step_rad;
}

// Keeps the candidates that are not near an earlier kept candidate, in order.
std::vector<PoseCandidate> SuppressNeighbors(const std::vector<PoseCandidate>& ordered,
                                             const VoteGrid& grid, double yaw_step_rad,
                                             size_t max_candidates) {
  std::vector<PoseCandidate> kept;
  for (const PoseCandidate& candidate : ordered) {
    const bool suppressed = std::any_of(kept.begin(), kept.end(), [&](const PoseCandidate& other) {
      return IsNear(candidate, other, grid, yaw_step_rad);
    });
    if (!suppressed && kept.size() < max_candidates) {
      kept.push_back(candidate);
    }
  }
  return kept;
}

// Replaces each candidate by judge(rays, center, yaw, options), as long as there is time.
template <typename Judge>
void JudgeCandidates(const RayArrays<double>& rays, const VotingOptions& options,
                     const Judge& judge, SharedWorkers* workers, const StopFunction& should_stop,
                     std::vector<PoseCandidate>* candidates) {
  ForEachStep(workers, static_cast<int>(candidates->size()), [&](int i) {
    if (!should_stop || !should_stop()) {
      PoseCandidate& candidate = (*candidates)[i];
      candidate = judge(rays, candidate.center_in_anchor, candidate.yaw_rad, options);
    }
  });
}

}  // namespace

VotedPoses VoteForPoses(const QueryContext& query,
                        const std::vector<Correspondence>& correspondences,
                        const VotingOptions& options, SharedWorkers* workers,
                        const StopFunction& should_stop) {
  CAIRN_CHECK(query.level_from_cam.has_value(), "voting needs gravity");
  const std::vector<VoteRay> rays = MakeVoteRays(query, correspondences, options);
  if (rays.empty()) {
    return {};
  }
  const VoteGrid grid = MakeGrid(rays, query.region, options);
  const Eigen::Vector3d center(query.region.prior_xy_in_anchor.x(),
                               query.region.prior_xy_in_anchor.y(), rays.front().x_in_anchor.z());
  const Ballot ballot = {RayArrays<float>(rays, center), grid, query.region.radius_m,
                         std::cos(options.max_azimuth_difference_rad),
                         static_cast<int>(std::ceil(2.0 * kPi / options.yaw_step_rad - 1e-3))};

  // Votes rank poses on a coarse lattice in which every vote of a cell counts the same. The support
  // of a pose ranks better but takes too long for all cells, so only kJudgedPerCandidate times the
  // requested number of maxima are judged by support.
  constexpr int kJudgedPerCandidate = 4;
  const Peaks peaks = FindPeaks(ballot, options, workers, should_stop);
  std::vector<PoseCandidate> candidates;
  for (const VotePeak& peak : peaks.best) {
    candidates.push_back(CandidateAt(peak, grid, ballot.num_yaws));
  }
  candidates = SuppressNeighbors(candidates, grid, options.yaw_step_rad,
                                 kJudgedPerCandidate * options.max_candidates);
  const RayArrays<double> support_rays(rays, center);
  JudgeCandidates(support_rays, options, SupportedCandidate, workers, should_stop, &candidates);
  std::erase_if(candidates, [&](const PoseCandidate& candidate) {
    return candidate.score < options.min_score;
  });
  if (options.filter != OutlierFilter::kVoting3d) {
    JudgeCandidates(support_rays, options, SettledCandidate, workers, should_stop, &candidates);
  }
  if (should_stop && should_stop()) {
    return {.candidates = {}, .num_votes = peaks.num_votes};
  }
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const PoseCandidate& a, const PoseCandidate& b) { return a.score > b.score; });
  // Different candidates may have settled at the same place.
  candidates = SuppressNeighbors(candidates, grid, options.yaw_step_rad, options.max_candidates);
  return {std::move(candidates), peaks.num_votes};
}

}  // namespace cairn
