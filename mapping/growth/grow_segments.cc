#include "mapping/growth/grow_segments.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/focal_length.h"
#include "core/parallel_for.h"
#include "mapping/growth/draft.h"
#include "mapping/growth/gps_check.h"
#include "mapping/growth/propose_photo.h"
#include "mapping/growth/view_graph.h"

namespace cairn {
namespace {

// Seeds of a photo that are tried. The best ones fail where facades repeat or cameras turn.
constexpr int kMaxSeedsOfPhoto = 10;
// A photo that was refused is tried again once it sees this many times the landmarks.
constexpr double kRetryGrowth = 1.2;
// A draft of more photos is adjusted as a whole only when nothing joins it any more. Until then,
// what joined is adjusted together with what it is linked with: the rest does not change by it, and
// the time of an adjustment grows faster than the number of photos. Smaller drafts, whose cameras
// may still be guesses, are adjusted as a whole each time.
constexpr int kManyPhotos = 200;

// The landmarks that photos saw when they were refused.
struct Refusals {
  explicit Refusals(size_t num_photos)
      : since_adjustment(num_photos, 0), joined(num_photos, 0), lost(num_photos, 0) {}

  int Observations(int photo) const { return std::max(since_adjustment[photo], lost[photo]); }

  std::vector<int> since_adjustment;  // An adjustment may change the verdict.
  std::vector<int> joined;            // When they last joined the draft.
  // The most that they saw when they joined the draft or left it again. It only grows, so that no
  // photo joins and leaves for ever.
  std::vector<int> lost;
};

class Grower {
 public:
  Grower(const PhotoSet& set, std::span<const TwoView> views, const GrowthOptions& options,
         const GrowthProgress& progress)
      : set_(set),
        options_(options),
        progress_(progress),
        tracks_(set, views),
        graph_(set, views, options),
        proposer_(set, graph_, options),
        verdicts_(set.photos.size(), PhotoVerdict::kNoTwoView),
        num_seeds_tried_(set.photos.size(), 0) {
    for (size_t i = 0; i < verdicts_.size(); ++i) {
      if (!graph_.ViewsOf(static_cast<int>(i)).empty()) {
        verdicts_[i] = PhotoVerdict::kNoSeed;
      }
    }
    for (const MappingCamera& camera : set.cameras) {
      cameras_.push_back(camera.camera);
    }
  }

  Growth Run() {
    Growth growth;
    const std::vector<Seed> seeds = FindSeeds(graph_, static_cast<int>(set_.photos.size()));
    while (std::optional<Draft> draft = Plant(seeds)) {
      Grow(&*draft);
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
    std::stable_sort(growth.segments.begin(), growth.segments.end(),
                     [](const Segment& p, const Segment& q) {
                       return p.photo_of_image.size() > q.photo_of_image.size();
                     });
    growth.verdict_of_photo = verdicts_;
    return growth;
  }

 private:
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
      const TwoView& base = graph_.View(seed.base_view);
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
    const TwoView& base = graph_.View(seed.base_view);
    Draft draft(set_, tracks_, cameras_, options_.num_threads);
    ScaleGuess(base.a, base.focal_factor_a, &draft);
    ScaleGuess(base.b, base.focal_factor_b, &draft);
    draft.Add(base.a, Rigid3d());
    draft.Add(base.b, base.b_from_a);
    const std::vector<int> pair = {base.a, base.b};
    draft.Triangulate(pair);
    Proposal third = proposer_.Localize(draft, seed.third);
    if (!third.pose) {
      return std::nullopt;
    }
    draft.SetCamera(set_.photos[seed.third].camera_idx, third.pose->camera);
    draft.Add(seed.third, third.pose->cam_from_world);
    const std::vector<int> all = {base.a, base.b, seed.third};
    draft.Triangulate(all);
    const bool is_adjusted = draft.AdjustAll() && draft.AdjustAll();
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
             proposer_.AskAbout(draft, photo, {draft.PoseOf(photo), draft.CameraOf(photo)})
                     .num_witnesses >= 2;
    });
  }

  // Photos next to a draft that see enough landmarks and more than when they were refused.
  std::vector<int> Candidates(const Draft& draft, const Refusals& refusals) const {
    std::vector<int> candidates;
    for (int photo = 0; photo < static_cast<int>(set_.photos.size()); ++photo) {
      if (draft.Has(photo) || !IsFree(photo)) {
        continue;
      }
      const bool is_neighbor =
          std::any_of(graph_.ViewsOf(photo).begin(), graph_.ViewsOf(photo).end(),
                      [&](int view) { return draft.Has(graph_.OtherOf(view, photo)); });
      const int num_observations =
          is_neighbor ? static_cast<int>(draft.ObservationsOf(photo).size()) : 0;
      if (num_observations >= options_.min_inliers &&
          num_observations > kRetryGrowth * refusals.Observations(photo)) {
        candidates.push_back(photo);
      }
    }
    return candidates;
  }

  // One round: localizes all candidates at once and adds those that are accepted. Returns them.
  std::vector<int> GrowOnce(Draft* draft, Refusals* refusals, bool is_last_resort) {
    const std::vector<int> candidates = Candidates(*draft, *refusals);
    const GpsCheck gps = MakeGpsCheck(*draft);
    std::vector<Proposal> proposals(candidates.size());
    ParallelFor(static_cast<int>(candidates.size()), options_.num_threads, [&](int i) {
      proposals[i] = proposer_.Propose(*draft, gps, candidates[i], is_last_resort);
    });
    std::vector<int> added;
    for (const Proposal& proposal : proposals) {
      verdicts_[proposal.photo] = proposal.verdict;
      if (proposal.verdict != PhotoVerdict::kInSegment) {
        refusals->since_adjustment[proposal.photo] = proposal.num_observations;
        continue;
      }
      const int camera_idx = set_.photos[proposal.photo].camera_idx;
      if (draft->IsNewCamera(camera_idx)) {
        draft->SetCamera(camera_idx, proposal.pose->camera);
      }
      draft->Add(proposal.photo, proposal.pose->cam_from_world);
      refusals->joined[proposal.photo] = proposal.num_observations;
      added.push_back(proposal.photo);
      // Until the draft is finished, the photo is not taken.
      verdicts_[proposal.photo] = PhotoVerdict::kLostSupport;
    }
    if (!added.empty()) {
      draft->Triangulate(added);
      if (!draft->AdjustAround(added)) {
        Remove(added, draft, refusals);
        return {};
      }
      draft->Triangulate(added);
      for (const int photo : RemoveWeak(draft, refusals)) {
        std::erase(added, photo);
      }
    }
    return added;
  }

  GpsCheck MakeGpsCheck(const Draft& draft) const {
    return GpsCheck(set_, draft, options_.default_gps_accuracy_m, options_.seed);
  }

  // Photos leave the draft. They may join again once they see more.
  static void Remove(const std::vector<int>& photos, Draft* draft, Refusals* refusals) {
    draft->Remove(photos);
    for (const int photo : photos) {
      refusals->lost[photo] = std::max({refusals->lost[photo], refusals->joined[photo],
                                        static_cast<int>(draft->ObservationsOf(photo).size())});
    }
  }

  // Photos with too few observations leave. Returns them.
  std::vector<int> RemoveWeak(Draft* draft, Refusals* refusals) const {
    const std::vector<int> counts = draft->CountObservations();
    std::vector<int> weak;
    for (const int photo : draft->photos()) {
      if (counts[photo] < options_.min_inliers) {
        weak.push_back(photo);
      }
    }
    Remove(weak, draft, refusals);
    return weak;
  }

  // Photos whose positions contradict the rest leave: a segment that was too small for positions
  // took them, and the photos around them show the same repetition. `photos` of the draft are
  // asked. True if there were any.
  bool RemoveContradicted(const std::vector<int>& photos, Draft* draft, Refusals* refusals) {
    const GpsCheck gps = MakeGpsCheck(*draft);
    std::vector<int> contradicted;
    for (const int photo : photos) {
      const Rigid3d& cam_from_world = draft->PoseOf(photo);
      const Testimony testimony =
          proposer_.AskAbout(*draft, photo, {cam_from_world, draft->CameraOf(photo)});
      if (proposer_.IsElsewhere(gps, testimony, photo, cam_from_world)) {
        contradicted.push_back(photo);
      }
    }
    if (contradicted.empty()) {
      contradicted = gps.BeyondStep();
    }
    for (const int photo : contradicted) {
      verdicts_[photo] = PhotoVerdict::kGpsContradicts;
    }
    Remove(contradicted, draft, refusals);
    return !contradicted.empty();
  }

  // Adjusts the whole draft. If the solver fails, the photos of `since` leave it.
  void AdjustAll(const std::vector<int>& since, bool is_final, Draft* draft, Refusals* refusals) {
    if (!draft->AdjustAll(is_final)) {
      Remove(since, draft, refusals);
    }
    RemoveWeak(draft, refusals);
    while (RemoveContradicted(draft->photos(), draft, refusals)) {
      draft->AdjustAll(is_final);
      RemoveWeak(draft, refusals);
    }
  }

  // Those of the photos that are in the draft, and the photos of the draft that they are linked
  // with. Ascending.
  std::vector<int> WithNeighbors(const std::vector<int>& photos, const Draft& draft) const {
    std::vector<int> near;
    for (const int photo : photos) {
      near.push_back(photo);
      for (const int view : graph_.ViewsOf(photo)) {
        near.push_back(graph_.OtherOf(view, photo));
      }
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    std::erase_if(near, [&](int photo) { return !draft.Has(photo); });
    return near;
  }

  // Adjusts the photos of `since` and those that they are linked with. If the solver fails, the
  // photos of `since` leave the draft.
  void AdjustNear(const std::vector<int>& since, Draft* draft, Refusals* refusals) {
    bool is_changed = true;
    while (is_changed) {
      const std::vector<int> near = WithNeighbors(since, *draft);
      if (near.empty()) {
        return;
      }
      if (draft->AdjustAround(near)) {
        draft->Triangulate(near);
      } else {
        Remove(since, draft, refusals);
      }
      RemoveWeak(draft, refusals);
      is_changed = RemoveContradicted(WithNeighbors(since, *draft), draft, refusals);
    }
  }

  void Grow(Draft* draft) {
    Refusals refusals(set_.photos.size());
    int num_at_last = draft->num_photos();  // Adjustment.
    int num_at_final = 0;                   // Adjustment of the whole after nothing joined.
    std::vector<int> since_adjustment;      // Photos that joined.
    bool is_final = false;
    while (true) {
      const std::vector<int> added = GrowOnce(draft, &refusals, is_final);
      since_adjustment.insert(since_adjustment.end(), added.begin(), added.end());
      if (progress_) {
        progress_(num_in_segments_ + draft->num_photos(), static_cast<int>(set_.photos.size()));
      }
      const bool has_many = draft->num_photos() > kManyPhotos;
      const bool is_due =
          draft->num_photos() > (has_many ? options_.adjust_after_growth * kManyPhotos + num_at_last
                                          : (1.0 + options_.adjust_after_growth) * num_at_last);
      if (!added.empty() && !is_due) {
        is_final = false;
        continue;
      }
      if (added.empty() && is_final) {
        break;
      }
      const bool has_many_new =
          draft->num_photos() > (1.0 + options_.adjust_after_growth) * num_at_final;
      if (!has_many || (added.empty() && has_many_new)) {
        AdjustAll(since_adjustment, /*is_final=*/added.empty(), draft, &refusals);
        num_at_final = added.empty() ? draft->num_photos() : num_at_final;
      } else {
        AdjustNear(since_adjustment, draft, &refusals);
      }
      since_adjustment.clear();
      std::fill(refusals.since_adjustment.begin(), refusals.since_adjustment.end(), 0);
      num_at_last = draft->num_photos();
      // After an adjustment that followed a round without a new photo, one more round is tried.
      is_final = added.empty();
    }
    // Landmarks that fit only now join the adjustment. Those of many photos do so when the segment
    // is placed.
    for (int round = 0; round < 2 && draft->num_photos() <= kManyPhotos; ++round) {
      draft->AdjustAll(/*is_final=*/true);
    }
    RemoveWeak(draft, &refusals);
    while (RemoveContradicted(draft->photos(), draft, &refusals)) {
      draft->AdjustAll(/*is_final=*/true);
      RemoveWeak(draft, &refusals);
    }
  }

  const PhotoSet& set_;
  const GrowthOptions& options_;
  const GrowthProgress& progress_;
  TrackTable tracks_;
  ViewGraph graph_;
  Proposer proposer_;
  std::vector<PhotoVerdict> verdicts_;
  std::vector<Camera> cameras_;
  size_t next_seed_ = 0;
  std::vector<int> num_seeds_tried_;  // Of each photo.
  int num_in_segments_ = 0;
};

}  // namespace

Growth GrowSegments(const PhotoSet& set, std::span<const TwoView> views,
                    const GrowthOptions& options, const GrowthProgress& progress) {
  options.Validate();
  set.Validate();
  return Grower(set, views, options, progress).Run();
}

}  // namespace cairn
