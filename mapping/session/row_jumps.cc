#include "mapping/session/row_jumps.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/geodesy.h"
#include "core/statistics.h"

namespace cairn {
namespace {

// Among six photos, three standard deviations are five medians.
constexpr size_t kRowPhotos = 6;
constexpr double kJump = 5.0;
// A walk comes back if, after the run, it is within this share of the jumps of where it was before,
// or not farther on than this many times what its usual steps make.
constexpr double kBackShare = 0.5;
constexpr double kBackSteps = 1.5;
// Runs of more than this share of the photos are a walk of their own.
constexpr double kMaxRunShare = 0.25;
constexpr double kSamePlaceM = 0.1;

// Photos before and after a jump show the same if two pairs across it have these shares of the
// inliers of the strongest pair there. Copies of facades reach a twentieth.
constexpr double kLinkShare = 0.5;
constexpr double kSecondLinkShare = 0.25;

// What is compared along the row, and dropped where it is wrong.
enum class Part { kPosition, kHeight };

// The accuracy of a height, in those of its position.
constexpr double kHeightError = 2.0;

struct Fix {
  int photo = 0;
  Eigen::Vector3d x_m;  // In ECEF, on the ellipsoid; or the height and zeros.
  double accuracy_m = 0.0;
};

std::vector<Fix> FixesOf(const PhotoSet& set, double accuracy_m, Part part) {
  std::vector<Fix> fixes;
  for (size_t i = 0; i < set.photos.size(); ++i) {
    const MappingPhoto& photo = set.photos[i];
    if (!photo.gps || (part == Part::kHeight && !photo.gps_has_height)) {
      continue;
    }
    const double stated_m = photo.gps_accuracy_m.value_or(accuracy_m);
    if (part == Part::kPosition) {
      const Geodetic on_ellipsoid = {photo.gps->lat_rad, photo.gps->lon_rad, 0.0};
      fixes.push_back({static_cast<int>(i), EcefFromGeodetic(on_ellipsoid), stated_m});
    } else {
      fixes.push_back({static_cast<int>(i), {photo.gps->h_m, 0.0, 0.0}, kHeightError * stated_m});
    }
  }
  return fixes;
}

double Distance(const Fix& p, const Fix& q) { return (p.x_m - q.x_m).norm(); }

// The fixes before and after one of them, as many on each side where there are as many.
std::vector<Fix> RowAround(const std::vector<Fix>& fixes, size_t i) {
  const size_t num_row = std::min(kRowPhotos, fixes.size() - 1);
  const size_t first = std::min(i - std::min(i, kRowPhotos / 2), fixes.size() - 1 - num_row);
  std::vector<Fix> row;
  for (size_t k = first; k <= first + num_row; ++k) {
    if (k != i) {
      row.push_back(fixes[k]);
    }
  }
  return row;
}

bool JumpsOutOf(const std::vector<Fix>& row, const Fix& fix) {
  if (row.size() < kRowPhotos) {
    return false;
  }
  std::vector<Eigen::Vector3d> points_m;
  for (const Fix& other : row) {
    points_m.push_back(other.x_m);
  }
  const Eigen::Vector3d median = MedianPoint(points_m);
  std::vector<double> distances_m;
  for (const Fix& other : row) {
    distances_m.push_back((other.x_m - median).norm());
  }
  const double usual_m = std::max(fix.accuracy_m, Median(std::move(distances_m)));
  return (fix.x_m - median).norm() > kJump * usual_m;
}

// The photos of the set, and the part of their positions that is compared.
struct Row {
  PhotoSet* set = nullptr;
  Part part = Part::kPosition;
  std::vector<Fix> fixes;
};

// Drops the fixes that `is_wrong` says are.
void Drop(const std::vector<bool>& is_wrong, Row* row) {
  std::vector<Fix> kept;
  for (size_t i = 0; i < row->fixes.size(); ++i) {
    MappingPhoto& photo = row->set->photos[row->fixes[i].photo];
    if (!is_wrong[i]) {
      kept.push_back(row->fixes[i]);
    } else if (row->part == Part::kPosition) {
      photo.gps.reset();
      photo.gps_accuracy_m.reset();
    } else {
      photo.gps_has_height = false;
    }
  }
  row->fixes = std::move(kept);
}

// Fixes [begin, end), each near the next.
struct Run {
  size_t begin = 0, end = 0;

  size_t size() const { return end - begin; }
};

double UsualStepM(const std::vector<Fix>& fixes) {
  std::vector<double> steps_m;
  for (size_t i = 1; i < fixes.size(); ++i) {
    steps_m.push_back(Distance(fixes[i - 1], fixes[i]));
  }
  return steps_m.empty() ? 0.0 : Median(std::move(steps_m));
}

std::vector<Run> RunsOf(const std::vector<Fix>& fixes, double usual_step_m) {
  std::vector<Run> runs;
  for (size_t i = 0; i < fixes.size(); ++i) {
    if (i == 0 ||
        Distance(fixes[i - 1], fixes[i]) > kJump * std::max(usual_step_m, fixes[i].accuracy_m)) {
      runs.push_back({i, i});
    }
    runs.back().end = i + 1;
  }
  return runs;
}

// True if the walk goes on after the run where it was before it.
bool JumpsAndReturns(const std::vector<Fix>& fixes, double usual_step_m, const Run& before,
                     const Run& run, const Run& after) {
  const double jump_m = std::min(Distance(fixes[before.end - 1], fixes[run.begin]),
                                 Distance(fixes[run.end - 1], fixes[after.begin]));
  const double usual_m = usual_step_m * static_cast<double>(run.size() + 1);
  return before.size() > run.size() && after.size() > run.size() &&
         static_cast<double>(run.size()) <= kMaxRunShare * static_cast<double>(fixes.size()) &&
         Distance(fixes[before.end - 1], fixes[after.begin]) <=
             std::max(kBackShare * jump_m, kBackSteps * usual_m);
}

bool StandsStill(const std::vector<Fix>& fixes, const Run& run) {
  for (size_t i = run.begin; i < run.end; ++i) {
    if (Distance(fixes[run.begin], fixes[i]) > kSamePlaceM) {
      return false;
    }
  }
  return run.size() > 1;
}

void Mark(const Run& run, std::vector<bool>* is_wrong) {
  std::fill(is_wrong->begin() + static_cast<std::ptrdiff_t>(run.begin),
            is_wrong->begin() + static_cast<std::ptrdiff_t>(run.end), true);
}

// True if the two photos before the jump from one run to the next and the two after it show the
// same. A run may have only one.
bool ShowTheSame(const PhotoSet& set, const std::vector<Fix>& fixes, const Run& before,
                 const Run& after, const TwoViewOptions& options) {
  const size_t begin = before.end - std::min<size_t>(2, before.size());
  const size_t end = after.begin + std::min<size_t>(2, after.size());
  std::vector<std::pair<int, int>> pairs;
  for (size_t i = begin; i < end; ++i) {
    for (size_t k = i + 1; k < end; ++k) {
      pairs.emplace_back(fixes[i].photo, fixes[k].photo);
    }
  }
  double beside = 0.0;
  std::vector<double> across;
  for (const TwoView& view : FindTwoViews(set, pairs, options)) {
    const auto num_inliers = static_cast<double>(view.inliers.size());
    if (view.a <= fixes[before.end - 1].photo && view.b >= fixes[after.begin].photo) {
      across.push_back(num_inliers);
    } else {
      beside = std::max(beside, num_inliers);
    }
  }
  std::ranges::sort(across, std::greater());
  return across.size() >= 2 && across[0] >= kLinkShare * beside &&
         across[1] >= kSecondLinkShare * std::max(beside, across[0]);
}

// The median distance of all fixes from a run.
double MedianDistanceM(const std::vector<Fix>& fixes, const Run& run) {
  std::vector<double> distances_m;
  for (const Fix& fix : fixes) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (size_t i = run.begin; i < run.end; ++i) {
      nearest_m = std::min(nearest_m, Distance(fix, fixes[i]));
    }
    distances_m.push_back(nearest_m);
  }
  return Median(std::move(distances_m));
}

void DropSingle(Row* row) {
  std::vector<bool> is_wrong(row->fixes.size(), false);
  for (size_t i = 0; i < row->fixes.size(); ++i) {
    is_wrong[i] = JumpsOutOf(RowAround(row->fixes, i), row->fixes[i]);
  }
  Drop(is_wrong, row);
}

// Runs that the row alone shows to be wrong.
void DropRuns(Row* row) {
  const std::vector<Fix>& fixes = row->fixes;
  const double usual_step_m = UsualStepM(fixes);
  const std::vector<Run> runs = RunsOf(fixes, usual_step_m);
  std::vector<bool> is_wrong(fixes.size(), false);
  for (size_t i = 0; i < runs.size() && runs.size() > 1; ++i) {
    const bool is_end = i == 0 || i + 1 == runs.size();
    if (is_end ? StandsStill(fixes, runs[i])
               : JumpsAndReturns(fixes, usual_step_m, runs[i - 1], runs[i], runs[i + 1])) {
      Mark(runs[i], &is_wrong);
    }
  }
  Drop(is_wrong, row);
}

// Runs that show the same as the next, but for the one nearest to the photos.
void DropLinkedRuns(const TwoViewOptions& options, Row* row) {
  const std::vector<Fix>& fixes = row->fixes;
  const std::vector<Run> runs = RunsOf(fixes, UsualStepM(fixes));
  std::vector<bool> is_wrong(fixes.size(), false);
  for (size_t begin = 0, end = 1; begin < runs.size(); begin = end++) {
    while (end < runs.size() && runs[end - 1].size() + runs[end].size() > 2 &&
           ShowTheSame(*row->set, fixes, runs[end - 1], runs[end], options)) {
      ++end;
    }
    const std::span<const Run> linked = std::span(runs).subspan(begin, end - begin);
    if (linked.size() > 1) {
      const auto believed = std::ranges::min_element(
          linked, {}, [&](const Run& run) { return MedianDistanceM(fixes, run); });
      for (auto run = linked.begin(); run != linked.end(); ++run) {
        if (run != believed) {
          Mark(*run, &is_wrong);
        }
      }
    }
  }
  Drop(is_wrong, row);
}

}  // namespace

void DropJumps(double accuracy_m, const TwoViewOptions& options, PhotoSet* set) {
  for (const Part part : {Part::kPosition, Part::kHeight}) {
    Row row = {set, part, FixesOf(*set, accuracy_m, part)};
    DropSingle(&row);
    DropRuns(&row);
    DropLinkedRuns(options, &row);
  }
}

}  // namespace cairn
