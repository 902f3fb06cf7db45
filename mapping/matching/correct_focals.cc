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
// EXIF rounds, and some cameras mean the diagonal: together 10 %. Of photos of facades whose other
// cameras are known, the pairs tell focal lengths within 5 %. Beyond both, one of two is wrong.
const double kMinLogError = std::log(1.2);
// The focal length of EXIF has to cost this much more than the best: in odds, 20,000 to 1.
constexpr double kMinExcess = 10.0;
// One camera among others whose focal lengths are a little off: one of a facade was found 18 % too
// long.
constexpr double kMinLogSigmaFound = 0.15;
// A view takes sides if the two focal lengths differ by this cost. At least kMinAgainst views have
// to contradict EXIF, and kMinAgainstPerFor times as many as support it.
constexpr double kMinDifference = 0.5;
constexpr int kMinAgainst = 3, kMinAgainstPerFor = 3;

// A view by which a camera is judged, and what it says if the other camera is right.
struct Judged {
  int camera = 0;
  const TwoView* view = nullptr;
  FocalCosts costs = {};
};

// The views of each camera whose focal length may be wrong, evenly over the set.
std::vector<std::vector<Judged>> ViewsToJudge(const PhotoSet& set, std::span<const TwoView> views) {
  std::vector<std::vector<Judged>> all_of_camera(set.cameras.size());
  for (const TwoView& view : views) {
    if (view.kind != TwoViewKind::kGeneral || view.inliers.size() < kMinInliersToDoubt) {
      continue;
    }
    const int camera_a = set.photos[view.a].camera_idx, camera_b = set.photos[view.b].camera_idx;
    const auto is_known = [&](int camera) {
      return set.cameras[camera].source != FocalSource::kGuess;
    };
    if (is_known(camera_b)) {
      all_of_camera[camera_a].push_back({camera_a, &view});
    }
    if (camera_b != camera_a && is_known(camera_a)) {
      all_of_camera[camera_b].push_back({camera_b, &view});
    }
  }
  std::vector<std::vector<Judged>> chosen(set.cameras.size());
  for (size_t i = 0; i < set.cameras.size(); ++i) {
    const auto& all = all_of_camera[i];
    const size_t count = std::min(kMaxViewsOfCamera, all.size());
    for (size_t k = 0; k < count && set.cameras[i].source == FocalSource::kExif; ++k) {
      chosen[i].push_back(all[k * all.size() / count]);
    }
  }
  return chosen;
}

void Judge(const PhotoSet& set, std::span<const MappingCamera> cameras,
           const std::vector<Judged*>& judged, int num_threads) {
  ParallelFor(static_cast<int>(judged.size()), num_threads, [&](int i) {
    const int camera = judged[i]->camera;
    const TwoView* view = judged[i]->view;
    const PairVerdict verdict =
        JudgePair(set, cameras, *view, set.photos[view->a].camera_idx == camera,
                  set.photos[view->b].camera_idx == camera);
    for (int step = 0; step < kNumFocalSteps; ++step) {
      judged[i]->costs[step] = verdict.CostAt(step, step);
    }
  });
}

struct Contradiction {
  KnownFocal found;
  double excess = 0.0;  // By which the focal length of EXIF costs more.
};

// Nothing if the views do not contradict the focal length of the set.
std::optional<Contradiction> Contradicted(const std::vector<Judged>& views) {
  FocalCosts total{};
  for (const Judged& judged : views) {
    for (int step = 0; step < kNumFocalSteps; ++step) {
      total[step] += judged.costs[step];
    }
  }
  const std::optional<KnownFocal> found = VertexOf(total);
  const auto best = std::min_element(total.begin(), total.end());
  const double excess = total[kOwnFocalStep] - *best;
  if (!found || std::abs(std::log(found->factor)) < kMinLogError || excess < kMinExcess) {
    return std::nullopt;
  }
  int num_against = 0, num_for = 0;
  for (const Judged& judged : views) {
    const double difference = judged.costs[kOwnFocalStep] - judged.costs[best - total.begin()];
    num_against += difference > kMinDifference ? 1 : 0;
    num_for += difference < -kMinDifference ? 1 : 0;
  }
  if (num_against < std::max(kMinAgainst, kMinAgainstPerFor * num_for)) {
    return std::nullopt;
  }
  return Contradiction{*found, excess};
}

// Of a photo about whose lens nothing is known but what was found.
MappingCamera CameraWith(const KnownFocal& found, const MappingCamera& exif) {
  const Camera unknown = CameraOfUnknownFocal(exif.camera.width_px(), exif.camera.height_px());
  const double focal_px = found.factor * exif.camera.focal_px();
  return {WithFocalScaled(unknown, focal_px / unknown.focal_px()),
          FocalPrior{.log_sigma = std::max(found.log_sigma, kMinLogSigmaFound),
                     .with_distortion = true},
          FocalSource::kPhotos, /*may_be_cropped=*/true};
}

}  // namespace

std::optional<std::vector<MappingCamera>> CorrectFocals(const PhotoSet& set,
                                                        std::span<const TwoView> views,
                                                        int num_threads) {
  std::vector<std::vector<Judged>> views_of_camera = ViewsToJudge(set, views);
  std::vector<MappingCamera> cameras = set.cameras;
  std::vector<Judged*> to_judge;
  for (std::vector<Judged>& of_camera : views_of_camera) {
    for (Judged& judged : of_camera) {
      to_judge.push_back(&judged);
    }
  }
  bool has_changed = false;
  while (true) {
    Judge(set, cameras, to_judge, num_threads);
    std::optional<Contradiction> surest;
    int wrong = -1;
    for (size_t i = 0; i < cameras.size(); ++i) {
      const auto contradiction = Contradicted(views_of_camera[i]);
      if (contradiction && (!surest || contradiction->excess > surest->excess)) {
        surest = contradiction;
        wrong = static_cast<int>(i);
      }
    }
    if (!surest) {
      return has_changed ? std::optional(std::move(cameras)) : std::nullopt;
    }
    cameras[wrong] = CameraWith(surest->found, set.cameras[wrong]);
    has_changed = true;
    views_of_camera[wrong].clear();
    to_judge.clear();
    // A wrong camera made others look wrong, or right.
    for (std::vector<Judged>& of_camera : views_of_camera) {
      for (Judged& judged : of_camera) {
        if (set.photos[judged.view->a].camera_idx == wrong ||
            set.photos[judged.view->b].camera_idx == wrong) {
          to_judge.push_back(&judged);
        }
      }
    }
  }
}

}  // namespace cairn
