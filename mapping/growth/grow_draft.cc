#include "mapping/growth/grow_draft.h"

#include <algorithm>

#include "core/parallel_for.h"
#include "mapping/growth/gps_check.h"

namespace cairn {
namespace {

// A photo that was refused is tried again once it sees this many times the landmarks.
constexpr double kRetryGrowth = 1.2;

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

class DraftGrower {
 public:
  DraftGrower(const GrowthScene& scene, const DraftProgress& progress, Draft* draft,
              std::vector<PhotoVerdict>* verdicts)
      : set_(scene.set),
        options_(scene.options),
        graph_(scene.graph),
        proposer_(scene.proposer),
        adjustment_(scene.adjustment),
        progress_(progress),
        draft_(draft),
        verdicts_(*verdicts),
        refusals_(scene.set.photos.size()) {}

  void Grow() {
    int num_at_last = draft_->num_photos();  // Adjustment.
    int num_at_final = 0;                    // Adjustment of the whole after nothing joined.
    std::vector<int> since_adjustment;       // Photos that joined.
    bool is_final = false;
    while (true) {
      const std::vector<int> added = GrowOnce(is_final);
      since_adjustment.insert(since_adjustment.end(), added.begin(), added.end());
      if (progress_) {
        progress_(draft_->num_photos());
      }
      const bool has_many = draft_->num_photos() > kManyPhotos;
      const bool is_due = draft_->num_photos() >
                          (has_many ? options_.adjust_after_growth * kManyPhotos + num_at_last
                                    : (1.0 + options_.adjust_after_growth) * num_at_last);
      if (!added.empty() && !is_due) {
        is_final = false;
        continue;
      }
      if (added.empty() && is_final) {
        break;
      }
      const bool has_many_new =
          draft_->num_photos() > (1.0 + options_.adjust_after_growth) * num_at_final;
      if (!has_many || (added.empty() && has_many_new)) {
        AdjustAll(since_adjustment, /*is_final=*/added.empty());
        num_at_final = added.empty() ? draft_->num_photos() : num_at_final;
      } else {
        AdjustNear(since_adjustment);
      }
      since_adjustment.clear();
      std::fill(refusals_.since_adjustment.begin(), refusals_.since_adjustment.end(), 0);
      num_at_last = draft_->num_photos();
      // After an adjustment that followed a round without a new photo, one more round is tried.
      is_final = added.empty();
    }
    Finish();
  }

 private:
  // Photos next to a draft that see enough landmarks and more than when they were refused.
  std::vector<int> Candidates() const {
    std::vector<int> candidates;
    for (int photo = 0; photo < static_cast<int>(set_.photos.size()); ++photo) {
      if (draft_->Has(photo) || verdicts_[photo] == PhotoVerdict::kInSegment) {
        continue;
      }
      const bool is_neighbor =
          std::any_of(graph_.ViewsOf(photo).begin(), graph_.ViewsOf(photo).end(),
                      [&](int view) { return draft_->Has(graph_.OtherOf(view, photo)); });
      const int num_observations =
          is_neighbor ? static_cast<int>(draft_->ObservationsOf(photo).size()) : 0;
      if (num_observations >= options_.min_inliers &&
          num_observations > kRetryGrowth * refusals_.Observations(photo)) {
        candidates.push_back(photo);
      }
    }
    return candidates;
  }

  // One round: localizes all candidates at once and adds those that are accepted. Returns them.
  std::vector<int> GrowOnce(bool is_last_resort) {
    const std::vector<int> candidates = Candidates();
    const GpsCheck gps = MakeGpsCheck();
    std::vector<Proposal> proposals(candidates.size());
    ParallelFor(static_cast<int>(candidates.size()), options_.num_threads, [&](int i) {
      proposals[i] = proposer_.Propose(*draft_, gps, candidates[i], is_last_resort);
    });
    std::vector<int> added;
    for (const Proposal& proposal : proposals) {
      verdicts_[proposal.photo] = proposal.verdict;
      if (proposal.verdict != PhotoVerdict::kInSegment) {
        refusals_.since_adjustment[proposal.photo] = proposal.num_observations;
        continue;
      }
      draft_->Add(proposal.photo, *proposal.pose);
      refusals_.joined[proposal.photo] = proposal.num_observations;
      added.push_back(proposal.photo);
      // Until the draft is finished, the photo is not taken.
      verdicts_[proposal.photo] = PhotoVerdict::kLostSupport;
    }
    if (!added.empty()) {
      draft_->Triangulate(added);
      if (!draft_->AdjustAround(added)) {
        Remove(added);
        return {};
      }
      draft_->Triangulate(added);
      for (const int photo : RemoveWeak()) {
        std::erase(added, photo);
      }
    }
    return added;
  }

  GpsCheck MakeGpsCheck() const {
    return GpsCheck(set_, *draft_, options_.default_gps_accuracy_m, options_.seed);
  }

  // Photos leave the draft. They may join again once they see more.
  void Remove(const std::vector<int>& photos) {
    draft_->Remove(photos);
    for (const int photo : photos) {
      refusals_.lost[photo] = std::max({refusals_.lost[photo], refusals_.joined[photo],
                                        static_cast<int>(draft_->ObservationsOf(photo).size())});
    }
  }

  // Photos with too few observations leave. Returns them.
  std::vector<int> RemoveWeak() {
    const std::vector<int> counts = draft_->CountObservations();
    std::vector<int> weak;
    for (const int photo : draft_->photos()) {
      if (counts[photo] < options_.min_inliers) {
        weak.push_back(photo);
      }
    }
    Remove(weak);
    return weak;
  }

  // Photos whose positions contradict the rest leave: a segment that was too small for positions
  // took them, and the photos around them show the same repetition. `photos` of the draft are
  // asked. True if there were any.
  bool RemoveContradicted(const std::vector<int>& photos) {
    const GpsCheck gps = MakeGpsCheck();
    std::vector<int> contradicted;
    for (const int photo : photos) {
      const Rigid3d& cam_from_world = draft_->PoseOf(photo);
      const Testimony testimony =
          proposer_.AskAbout(*draft_, photo, {cam_from_world, draft_->CameraOf(photo)});
      if (proposer_.IsElsewhere(*draft_, gps, testimony, photo, cam_from_world)) {
        contradicted.push_back(photo);
      }
    }
    if (contradicted.empty()) {
      contradicted = gps.BeyondStep();
    }
    for (const int photo : contradicted) {
      verdicts_[photo] = PhotoVerdict::kGpsContradicts;
    }
    Remove(contradicted);
    return !contradicted.empty();
  }

  // Adjusts the whole draft. If the solver fails, the photos of `since` leave it.
  void AdjustAll(const std::vector<int>& since, bool is_final) {
    if (!draft_->AdjustAll(is_final, adjustment_)) {
      Remove(since);
    }
    RemoveWeak();
    while (RemoveContradicted(draft_->photos())) {
      draft_->AdjustAll(is_final, adjustment_);
      RemoveWeak();
    }
  }

  // Those of the photos that are in the draft, and the photos of the draft that they are linked
  // with. Ascending.
  std::vector<int> WithNeighbors(const std::vector<int>& photos) const {
    std::vector<int> near;
    for (const int photo : photos) {
      near.push_back(photo);
      for (const int view : graph_.ViewsOf(photo)) {
        near.push_back(graph_.OtherOf(view, photo));
      }
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    std::erase_if(near, [&](int photo) { return !draft_->Has(photo); });
    return near;
  }

  // Adjusts the photos of `since` and those that they are linked with. If the solver fails, the
  // photos of `since` leave the draft.
  void AdjustNear(const std::vector<int>& since) {
    bool is_changed = true;
    while (is_changed) {
      const std::vector<int> near = WithNeighbors(since);
      if (near.empty()) {
        return;
      }
      if (draft_->AdjustAround(near)) {
        draft_->Triangulate(near);
      } else {
        Remove(since);
      }
      RemoveWeak();
      is_changed = RemoveContradicted(WithNeighbors(since));
    }
  }

  void Finish() {
    // Landmarks that fit only now join the adjustment. Those of many photos do so when the segment
    // is placed.
    for (int round = 0; round < 2 && draft_->num_photos() <= kManyPhotos; ++round) {
      draft_->AdjustAll(/*is_final=*/true, adjustment_);
    }
    RemoveWeak();
    while (RemoveContradicted(draft_->photos())) {
      draft_->AdjustAll(/*is_final=*/true, adjustment_);
      RemoveWeak();
    }
  }

  const PhotoSet& set_;
  const GrowthOptions& options_;
  const ViewGraph& graph_;
  const Proposer& proposer_;
  const AdjustProgress& adjustment_;
  const DraftProgress& progress_;
  Draft* draft_;
  std::vector<PhotoVerdict>& verdicts_;
  Refusals refusals_;
};

}  // namespace

void GrowDraft(const GrowthScene& scene, const DraftProgress& progress, Draft* draft,
               std::vector<PhotoVerdict>* verdicts) {
  DraftGrower(scene, progress, draft, verdicts).Grow();
}

}  // namespace cairn
