#include "mapping/growth/grow_segments.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/focal_length.h"
#include "mapping/growth/draft.h"
#include "mapping/growth/grow_draft.h"
#include "mapping/growth/growth_scene.h"
#include "mapping/growth/join_segments.h"
#include "mapping/growth/propose_photo.h"
#include "mapping/growth/view_graph.h"

namespace cairn {
namespace {

// Seeds of a photo that are tried. The best ones fail where facades repeat or cameras turn.
constexpr int kMaxSeedsOfPhoto = 10;

class Grower {
 public:
  Grower(const PhotoSet& set, std::span<const TwoView> views, const GrowthOptions& options,
         const GrowthProgress& progress, const AdjustProgress& adjustment)
      : set_(set),
        options_(options),
        progress_(progress),
        scene_(set, views, options, adjustment),
        verdicts_(set.photos.size(), PhotoVerdict::kNoTwoView),
        num_seeds_tried_(set.photos.size(), 0) {
    for (size_t i = 0; i < verdicts_.size(); ++i) {
      if (!scene_.graph.ViewsOf(static_cast<int>(i)).empty()) {
        verdicts_[i] = PhotoVerdict::kNoSeed;
      }
    }
    for (const MappingCamera& camera : set.cameras) {
      cameras_.push_back(camera.camera);
    }
  }

  Growth Run() {
    Growth growth;
    const std::vector<Seed> seeds = FindSeeds(scene_.graph, static_cast<int>(set_.photos.size()));
    while (std::optional<Draft> draft = Plant(seeds)) {
      GrowDraft(scene_, Reporter(), &*draft, &verdicts_);
      if (draft->num_photos() < options_.min_photos) {
        continue;
      }
      growth.segments.push_back(draft->Finish());
      for (const int photo : draft->photos()) {
        verdicts_[photo] = PhotoVerdict::kInSegment;
      }
      num_in_segments_ += draft->num_photos();
      KeepCameras(*draft, growth.segments.back().model.cameras);
    }
    JoinSegments(scene_, &growth.segments, &verdicts_);
    std::stable_sort(growth.segments.begin(), growth.segments.end(),
                     [](const Segment& p, const Segment& q) {
                       return p.photo_of_image.size() > q.photo_of_image.size();
                     });
    growth.verdict_of_photo = verdicts_;
    return growth;
  }

 private:
  DraftProgress Reporter() const {
    return [this](int num_photos) {
      if (progress_) {
        progress_(num_in_segments_ + num_photos, static_cast<int>(set_.photos.size()));
      }
    };
  }

  bool IsFree(int photo) const { return verdicts_[photo] != PhotoVerdict::kInSegment; }

  // What a segment found out about its cameras helps the next.
  void KeepCameras(const Draft& draft, const std::vector<Camera>& cameras) {
    for (size_t i = 0; i < cameras.size(); ++i) {
      if (!draft.IsNewCamera(static_cast<int>(i))) {
        cameras_[i] = cameras[i];
      }
    }
  }

  // A draft of three photos from the best seed that holds; nothing if none does. A seed that fails
  // or whose segment stayed too small is not tried again.
  std::optional<Draft> Plant(const std::vector<Seed>& seeds) {
    while (next_seed_ < seeds.size()) {
      const Seed& seed = seeds[next_seed_++];
      const TwoView& base = scene_.graph.View(seed.base_view);
      const std::array<int, 3> photos = {base.a, base.b, seed.third};
      if (!std::all_of(photos.begin(), photos.end(), [&](int photo) {
            return IsFree(photo) && num_seeds_tried_[photo] < kMaxSeedsOfPhoto;
          })) {
        continue;
      }
      for (const int photo : photos) {
        ++num_seeds_tried_[photo];
      }
      if (std::optional<Draft> draft = TrySeed(seed)) {
        return draft;
      }
    }
    return std::nullopt;
  }

  std::optional<Draft> TrySeed(const Seed& seed) const {
    const TwoView& base = scene_.graph.View(seed.base_view);
    Draft draft(set_, scene_.tracks, cameras_, options_.num_threads);
    ScaleGuess(base.a, base.focal_factor_a, &draft);
    ScaleGuess(base.b, base.focal_factor_b, &draft);
    draft.Add(base.a, Rigid3d());
    draft.Add(base.b, base.b_from_a);
    const std::vector<int> pair = {base.a, base.b};
    draft.Triangulate(pair);
    Proposal third = scene_.proposer.Localize(draft, seed.third);
    if (!third.pose) {
      return std::nullopt;
    }
    draft.Add(seed.third, *third.pose);
    const std::vector<int> all = {base.a, base.b, seed.third};
    draft.Triangulate(all);
    const bool is_adjusted =
        draft.AdjustAll(false, scene_.adjustment) && draft.AdjustAll(false, scene_.adjustment);
    // If the solver fails, another seed may do.
    return is_adjusted && Holds(draft) ? std::optional(std::move(draft)) : std::nullopt;
  }

  void ScaleGuess(int photo, double factor, Draft* draft) const {
    const int camera = set_.photos[photo].camera_idx;
    if (factor != 1.0 && draft->IsNewCamera(camera)) {
      draft->SetCamera(camera, WithFocalScaled(set_.cameras[camera].camera, factor));
    }
  }

  // True if all photos of a seed kept enough observations and agree with all two views.
  bool Holds(const Draft& draft) const {
    const std::vector<int> counts = draft.CountObservations();
    return std::all_of(draft.photos().begin(), draft.photos().end(), [&](int photo) {
      return counts[photo] >= options_.min_inliers &&
             scene_.proposer.AskAbout(draft, photo, {draft.PoseOf(photo), draft.CameraOf(photo)})
                     .num_witnesses >= 2;
    });
  }

  const PhotoSet& set_;
  const GrowthOptions& options_;
  const GrowthProgress& progress_;
  const GrowthScene scene_;
  std::vector<PhotoVerdict> verdicts_;
  std::vector<Camera> cameras_;
  size_t next_seed_ = 0;
  std::vector<int> num_seeds_tried_;  // Of each photo.
  int num_in_segments_ = 0;
};

}  // namespace

Growth GrowSegments(const PhotoSet& set, std::span<const TwoView> views,
                    const GrowthOptions& options, const GrowthProgress& progress,
                    const AdjustProgress& adjustment) {
  options.Validate();
  set.Validate();
  return Grower(set, views, options, progress, adjustment).Run();
}

}  // namespace cairn
