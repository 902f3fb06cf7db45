#include "mapping/matching/correct_focals.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/focal_length.h"
#include "core/parallel_for.h"
#include "mapping/matching/focal_grid.h"

namespace cairn {
namespace {

// Views of a camera that are looked at, and the inliers that each needs.
constexpr size_t kMaxViewsOfCamera = 20;
constexpr size_t kMinInliersToDoubt = 30;
// EXIF rounds, and some cameras mean the diagonal: together 10 %. Pairs tell focal lengths of
// facades within 28 % (decision 64). Beyond both, one of two is wrong.
const double kMinLogError = std::log(1.4);
// The focal length of EXIF has to cost this much more than the best: in odds, 20,000 to 1.
constexpr double kMinExcess = 10.0;
// One camera among others whose focal lengths are a little off: one of a facade was found 18 % too
// long.
constexpr double kMinLogSigmaFound = 0.15;
// A view takes sides if the two focal lengths differ by this cost. At least so many have to
// contradict EXIF, and this many times as many as support it.
constexpr double kMinDifference = 0.5;
constexpr int kMinAgainst = 3, kMinAgainstPerFor = 3;

// The views of each camera whose focal length may be wrong, evenly over the set.
std::vector<std::pair<int, const TwoView*>> ViewsToJudge(const PhotoSet& set,
                                                         std::span<const TwoView> views) {
  std::vector<std::vector<const TwoView*>> views_of_camera(set.cameras.size());
  for (const TwoView& view : views) {
    if (view.kind != TwoViewKind::kGeneral || view.inliers.size() < kMinInliersToDoubt) {
      continue;
    }
    const int camera_a = set.photos[view.a].camera_idx, camera_b = set.photos[view.b].camera_idx;
    const auto is_known = [&](int camera) {
      return set.cameras[camera].source != FocalSource::kGuess;
    };
    if (is_known(camera_b)) {
      views_of_camera[camera_a].push_back(&view);
    }
    if (camera_b != camera_a && is_known(camera_a)) {
      views_of_camera[camera_b].push_back(&view);
    }
  }
  std::vector<std::pair<int, const TwoView*>> chosen;
  for (size_t i = 0; i < set.cameras.size(); ++i) {
    const auto& all = views_of_camera[i];
    const size_t count = std::min(kMaxViewsOfCamera, all.size());
    for (size_t k = 0; k < count && set.cameras[i].source == FocalSource::kExif; ++k) {
      chosen.emplace_back(static_cast<int>(i), all[k * all.size() / count]);
    }
  }
  return chosen;
}

// Nothing if the views do not contradict the focal length of the set.
std::optional<KnownFocal> Contradicted(const std::vector<FocalCosts>& costs_of_view) {
  FocalCosts total{};
  for (const FocalCosts& costs : costs_of_view) {
    for (int step = 0; step < kNumFocalSteps; ++step) {
      total[step] += costs[step];
    }
  }
  const std::optional<KnownFocal> found = VertexOf(total);
  const auto best = std::min_element(total.begin(), total.end());
  if (!found || std::abs(std::log(found->factor)) < kMinLogError ||
      total[kOwnFocalStep] - *best < kMinExcess) {
    return std::nullopt;
  }
  int num_against = 0, num_for = 0;
  for (const FocalCosts& costs : costs_of_view) {
    const double excess = costs[kOwnFocalStep] - costs[best - total.begin()];
    num_against += excess > kMinDifference ? 1 : 0;
    num_for += excess < -kMinDifference ? 1 : 0;
  }
  return num_against >= std::max(kMinAgainst, kMinAgainstPerFor * num_for) ? found : std::nullopt;
}

// Of a photo about whose lens nothing is known but what was found.
MappingCamera CameraWith(const KnownFocal& found, const MappingCamera& exif) {
  const Camera unknown = CameraOfUnknownFocal(exif.camera.width_px(), exif.camera.height_px());
  const double focal_px = found.factor * exif.camera.focal_px();
  return {WithFocalScaled(unknown, focal_px / unknown.focal_px()),
          FocalPrior{.log_sigma = std::max(found.log_sigma, kMinLogSigmaFound),
                     .with_distortion = true},
          FocalSource::kPhotos};
}

}  // namespace

std::optional<std::vector<MappingCamera>> CorrectFocals(const PhotoSet& set,
                                                        std::span<const TwoView> views,
                                                        int num_threads) {
  const auto judged = ViewsToJudge(set, views);
  std::vector<FocalCosts> costs(judged.size());
  ParallelFor(static_cast<int>(judged.size()), num_threads, [&](int i) {
    const auto& [camera, view] = judged[i];
    const PairVerdict verdict = JudgePair(set, *view, set.photos[view->a].camera_idx == camera,
                                          set.photos[view->b].camera_idx == camera);
    for (int step = 0; step < kNumFocalSteps; ++step) {
      costs[i][step] = verdict.CostAt(step, step);
    }
  });
  std::vector<MappingCamera> cameras = set.cameras;
  bool has_changed = false;
  for (size_t first = 0, last = 0; first < judged.size(); first = last) {
    const int camera = judged[first].first;
    while (last < judged.size() && judged[last].first == camera) {
      ++last;
    }
    if (const auto found = Contradicted({costs.begin() + static_cast<std::ptrdiff_t>(first),
                                         costs.begin() + static_cast<std::ptrdiff_t>(last)})) {
      cameras[camera] = CameraWith(*found, set.cameras[camera]);
      has_changed = true;
    }
  }
  return has_changed ? std::optional(std::move(cameras)) : std::nullopt;
}

}  // namespace cairn
