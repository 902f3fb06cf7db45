#include "mapping/growth/join_segments.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/random.h"
#include "mapping/growth/align_segments.h"
#include "mapping/growth/draft.h"
#include "mapping/growth/gps_check.h"
#include "mapping/growth/grow_draft.h"
#include "mapping/growth/segment_guests.h"

namespace cairn {
namespace {

// Tracks that must agree on a similarity. Three determine it, and chance let 8 of 35 agree on a
// wrong one; the two views then decide.
constexpr int kMinSharedPoints = 10;
// Two views between two segments that must fit, and the photos of each segment that they are of.
constexpr int kMinBridges = 3;
constexpr int kMinBridgePhotos = 2;
// The two views that fit have this many times the inliers of those that do not.
constexpr int kBridgesBeyondDoubt = 4;
// The same if positions tell the places of both segments, and so would contradict a wrong union.
constexpr int kBridgesWithPlaces = 2;
// Of each segment, a union loses at most one photo, or this share if that is more.
constexpr double kMaxLostShare = 0.1;
// Two segments whose positions err by this factor more in the union than in each of them are not
// where the union has them. A few positions always fit, and then say that they err.
constexpr double kMaxNoiseGrowth = 1.5;
// A segment that is smaller than this share of one of many photos is adjusted to it; it does not
// change the whole.
constexpr double kSmallShare = 0.33;

// The two views that link two segments and know their directions.
struct Bridges {
  std::vector<int> views;
  size_t num_inliers = 0;
};

// Why two segments may be one place.
struct BridgeEvidence {
  int num_views = 0;
  int num_strong_views = 0;
  std::array<std::set<int>, 2> photos;  // Of each segment.
  size_t fitting_inliers = 0;
  size_t other_inliers = 0;
};

// A segment that became part of a larger one, and its identity.
struct Part {
  int id = 0;
  Segment segment;
};

class Joiner {
 public:
  Joiner(const GrowthScene& scene, std::vector<Segment>* segments,
         std::vector<PhotoVerdict>* verdicts)
      : scene_(scene), segments_(*segments), verdicts_(*verdicts) {
    for (size_t i = 0; i < segments_.size(); ++i) {
      ids_.push_back(next_id_++);
    }
  }

  void Run() {
    while (JoinAll()) {
      GrowOn();
    }
  }

 private:
  using Pair = std::pair<int, int>;  // Indices of segments, the one with more photos first.

  // Joins until no pair that was not tried yet is left. True if any joined.
  bool JoinAll() {
    bool has_joined = false;
    FindNeighbors();
    while (const std::optional<Pair> pair = StrongestUntried()) {
      const auto [a, b] = *pair;
      std::optional<Draft> joined = TryJoin(segments_[a], segments_[b], bridges_.at(*pair));
      if (!joined) {
        tried_.insert({ids_[a], ids_[b]});
        continue;
      }
      Replace(a, b, *joined);
      FindNeighbors();
      has_joined = true;
    }
    return has_joined;
  }

  void FindNeighbors() {
    segment_of_photo_.assign(scene_.set.photos.size(), -1);
    for (size_t i = 0; i < segments_.size(); ++i) {
      for (const int photo : segments_[i].photo_of_image) {
        segment_of_photo_[photo] = static_cast<int>(i);
      }
    }
    bridges_.clear();
    strongest_inside_.assign(scene_.set.photos.size(), 0);
    for (int photo = 0; photo < static_cast<int>(segment_of_photo_.size()); ++photo) {
      for (const int i : scene_.graph.ViewsOf(photo)) {
        const TwoView& view = scene_.graph.View(i);
        const int a = segment_of_photo_[view.a], b = segment_of_photo_[view.b];
        if (a < 0 || b < 0) {
          continue;
        }
        if (a == b) {
          strongest_inside_[photo] = std::max(strongest_inside_[photo], view.inliers.size());
        } else if (photo == view.a && scene_.graph.CanTestify(view) && MayJoin(a) && MayJoin(b)) {
          Bridges& bridges = bridges_[InOrder(a, b)];
          bridges.views.push_back(i);
          bridges.num_inliers += view.inliers.size();
        }
      }
    }
  }

  bool MayJoin(int segment) const { return !refused_.contains(ids_[segment]); }

  Pair InOrder(int i, int j) const {
    const size_t p = segments_[i].photo_of_image.size(), q = segments_[j].photo_of_image.size();
    return p > q || (p == q && i < j) ? Pair(i, j) : Pair(j, i);
  }

  std::optional<Pair> StrongestUntried() const {
    std::optional<Pair> strongest;
    size_t most = 0;
    for (const auto& [pair, bridges] : bridges_) {
      if (bridges.num_inliers > most && !tried_.contains({ids_[pair.first], ids_[pair.second]})) {
        most = bridges.num_inliers;
        strongest = pair;
      }
    }
    return strongest;
  }

  // The draft of both segments if they belong together.
  std::optional<Draft> TryJoin(const Segment& a, const Segment& b, const Bridges& bridges) const {
    if (!IsEnough(Weigh(bridges, [](const TwoView&) { return true; }), kBridgesBeyondDoubt)) {
      return std::nullopt;
    }
    const auto alignment = Align(a, b, bridges);
    if (!alignment) {
      return std::nullopt;
    }
    Draft draft = Unite(a, b, alignment->b_from_a.Inverse());
    const std::array<GpsCheck, 2> gps = {MakeGpsCheck(DraftOf(a)), MakeGpsCheck(DraftOf(b))};
    if (!AdjustUnion(a, b, &draft) || !IsWitnessed(bridges, gps, draft) ||
        LosesMany(a, b, gps, &draft)) {
      return std::nullopt;
    }
    return draft;
  }

  std::optional<SegmentAlignment> Align(const Segment& a, const Segment& b,
                                        const Bridges& bridges) const {
    const uint64_t seed = HashWord(scene_.options.seed ^
                                   HashWord(static_cast<uint64_t>(a.photo_of_image.front()) << 32 |
                                            static_cast<uint64_t>(b.photo_of_image.front())));
    if (auto alignment = AlignSegments(scene_.tracks, a, b, kMinSharedPoints, seed)) {
      return alignment;
    }
    const auto guests_in_a = WithGuests(scene_, a, b, bridges.views);
    const auto guests_in_b = WithGuests(scene_, b, a, bridges.views);
    return guests_in_a || guests_in_b
               ? AlignSegments(scene_.tracks, guests_in_a ? *guests_in_a : a,
                               guests_in_b ? *guests_in_b : b, kMinSharedPoints, seed)
               : std::nullopt;
  }

  // Counts the two views that `fits` says do.
  template <typename Fits>
  BridgeEvidence Weigh(const Bridges& bridges, const Fits& fits) const {
    BridgeEvidence evidence;
    for (const int i : bridges.views) {
      const TwoView& view = scene_.graph.View(i);
      if (!fits(view)) {
        evidence.other_inliers += view.inliers.size();
        continue;
      }
      ++evidence.num_views;
      evidence.fitting_inliers += view.inliers.size();
      const bool is_first = segment_of_photo_[view.a] < segment_of_photo_[view.b];
      evidence.photos[is_first ? 0 : 1].insert(view.a);
      evidence.photos[is_first ? 1 : 0].insert(view.b);
      const auto strongest =
          static_cast<double>(std::max(strongest_inside_[view.a], strongest_inside_[view.b]));
      evidence.num_strong_views +=
          static_cast<double>(view.inliers.size()) >= scene_.options.min_link_share * strongest ? 1
                                                                                                : 0;
    }
    return evidence;
  }

  bool IsEnough(const BridgeEvidence& evidence, int beyond_doubt) const {
    return evidence.num_views >= kMinBridges &&
           evidence.num_strong_views >= scene_.options.min_witnesses &&
           evidence.photos[0].size() >= kMinBridgePhotos &&
           evidence.photos[1].size() >= kMinBridgePhotos &&
           evidence.fitting_inliers >= beyond_doubt * evidence.other_inliers;
  }

  // `gps`: of each segment alone.
  bool IsWitnessed(const Bridges& bridges, const std::array<GpsCheck, 2>& gps,
                   const Draft& draft) const {
    const bool know_places = gps[0].KnowsPlace() && gps[1].KnowsPlace();
    const BridgeEvidence evidence = Weigh(bridges, [&](const TwoView& view) {
      return scene_.graph.MostInliersFit(view, {draft.PoseOf(view.a), draft.CameraOf(view.a)},
                                         {draft.PoseOf(view.b), draft.CameraOf(view.b)});
    });
    return IsEnough(evidence, know_places ? kBridgesWithPlaces : kBridgesBeyondDoubt);
  }

  // Both segments in the world of a, with the landmarks that both see.
  Draft Unite(const Segment& a, const Segment& b, const Sim3d& a_from_b) const {
    Draft draft = DraftOf(a);
    for (size_t i = 0; i < b.photo_of_image.size(); ++i) {
      const int camera = b.model.images[i].camera_idx;
      if (draft.IsNewCamera(camera)) {
        draft.SetCamera(camera, b.model.cameras[camera]);
      }
    }
    for (size_t i = 0; i < b.photo_of_image.size(); ++i) {
      draft.Add(b.photo_of_image[i], CamFromTarget(b.model.images[i].cam_from_world, a_from_b));
    }
    draft.Triangulate(b.photo_of_image);
    return draft;
  }

  // Adjusts the whole, or only the smaller segment if it is small beside many photos.
  bool AdjustUnion(const Segment& a, const Segment& b, Draft* draft) const {
    const auto num_a = static_cast<double>(a.photo_of_image.size());
    const auto num_b = static_cast<double>(b.photo_of_image.size());
    if (draft->num_photos() <= kManyPhotos || num_b > kSmallShare * num_a) {
      return draft->AdjustAll(/*is_final=*/true, scene_.adjustment);
    }
    if (!draft->AdjustAround(b.photo_of_image)) {
      return false;
    }
    draft->Triangulate(b.photo_of_image);
    return true;
  }

  // True if the positions show that one of the segments is elsewhere.
  static bool IsElsewhere(const std::array<GpsCheck, 2>& of_parts, const GpsCheck& gps) {
    const double noise = std::max(of_parts[0].noise_of_stated(), of_parts[1].noise_of_stated());
    return gps.noise_of_stated() > kMaxNoiseGrowth * noise || !gps.BeyondStep().empty();
  }

  Draft DraftOf(const Segment& segment) const {
    return Draft(scene_.set, scene_.tracks, segment, scene_.options.num_threads);
  }

  GpsCheck MakeGpsCheck(const Draft& draft) const {
    return GpsCheck(scene_.set, draft, scene_.options.default_gps_accuracy_m, scene_.options.seed);
  }

  // Removes photos that lost their landmarks or whose positions contradict the union. True if there
  // are many of them, or if a segment is elsewhere.
  bool LosesMany(const Segment& a, const Segment& b, const std::array<GpsCheck, 2>& of_parts,
                 Draft* draft) const {
    const GpsCheck gps = MakeGpsCheck(*draft);
    if (IsElsewhere(of_parts, gps)) {
      return true;
    }
    const std::vector<int> counts = draft->CountObservations();
    std::vector<int> lost;
    for (const int photo : draft->photos()) {
      const Rigid3d& pose = draft->PoseOf(photo);
      const Testimony testimony =
          scene_.proposer.AskAbout(*draft, photo, {pose, draft->CameraOf(photo)});
      if (counts[photo] < scene_.options.min_inliers ||
          scene_.proposer.IsElsewhere(*draft, gps, testimony, photo, pose)) {
        lost.push_back(photo);
      }
    }
    draft->Remove(lost);
    return HasLostMany(a, *draft) || HasLostMany(b, *draft);
  }

  static bool HasLostMany(const Segment& part, const Draft& draft) {
    const auto num_lost = std::count_if(part.photo_of_image.begin(), part.photo_of_image.end(),
                                        [&](int photo) { return !draft.Has(photo); });
    return static_cast<double>(num_lost) >
           std::max(1.0, kMaxLostShare * static_cast<double>(part.photo_of_image.size()));
  }

  // The draft takes the place of both segments.
  void Replace(int a, int b, const Draft& draft) {
    std::vector<Part> parts;
    for (const int i : {a, b}) {
      Take(segments_[i].photo_of_image, PhotoVerdict::kLostSupport);
      if (const auto found = parts_.find(ids_[i]); found != parts_.end()) {
        std::move(found->second.begin(), found->second.end(), std::back_inserter(parts));
        parts_.erase(found);
      } else {
        parts.push_back({ids_[i], std::move(segments_[i])});
      }
    }
    Take(draft.photos(), PhotoVerdict::kInSegment);
    segments_[a] = draft.Finish();
    ids_[a] = next_id_++;
    parts_[ids_[a]] = std::move(parts);
    segments_.erase(segments_.begin() + b);
    ids_.erase(ids_.begin() + b);
  }

  void Take(const std::vector<int>& photos, PhotoVerdict verdict) {
    for (const int photo : photos) {
      verdicts_[photo] = verdict;
    }
  }

  // Segments that joined become larger by the photos outside. If that, or the adjustments with
  // them, cost one of the parts many photos, the parts are taken apart again.
  void GrowOn() {
    for (int i = static_cast<int>(segments_.size()) - 1; i >= 0; --i) {
      const auto found = parts_.find(ids_[i]);
      if (found == parts_.end()) {
        continue;
      }
      const std::vector<Part> parts = std::move(found->second);
      parts_.erase(found);
      const std::vector<PhotoVerdict> before = verdicts_;
      Draft draft = DraftOf(segments_[i]);
      Take(draft.photos(), PhotoVerdict::kLostSupport);
      GrowDraft(scene_, {}, &draft, &verdicts_);
      Take(draft.photos(), PhotoVerdict::kInSegment);
      if (std::any_of(parts.begin(), parts.end(),
                      [&](const Part& part) { return HasLostMany(part.segment, draft); })) {
        verdicts_ = before;
        TakeApart(i, parts, draft);
      } else {
        segments_[i] = draft.Finish();
        ids_[i] = next_id_++;
      }
    }
  }

  // The parts take the place of a segment. Those that lost photos join no other any more.
  void TakeApart(int segment, const std::vector<Part>& parts, const Draft& draft) {
    segments_.erase(segments_.begin() + segment);
    ids_.erase(ids_.begin() + segment);
    for (const Part& part : parts) {
      Take(part.segment.photo_of_image, PhotoVerdict::kInSegment);
      segments_.push_back(part.segment);
      ids_.push_back(part.id);
      if (HasLostMany(part.segment, draft)) {
        refused_.insert(part.id);
      }
    }
  }

  const GrowthScene& scene_;
  std::vector<Segment>& segments_;
  std::vector<PhotoVerdict>& verdicts_;
  std::vector<int> ids_;  // Of the segments; a segment that changes gets another one.
  int next_id_ = 0;
  std::set<std::pair<int, int>> tried_;     // Ids.
  std::set<int> refused_;                   // Ids.
  std::map<int, std::vector<Part>> parts_;  // Of segments that have not grown since they joined.
  // Of the segments as they are.
  std::vector<int> segment_of_photo_;
  std::map<Pair, Bridges> bridges_;
  std::vector<size_t> strongest_inside_;  // Inliers of a photo's two views with its own segment.
};

}  // namespace

void JoinSegments(const GrowthScene& scene, std::vector<Segment>* segments,
                  std::vector<PhotoVerdict>* verdicts) {
  Joiner(scene, segments, verdicts).Run();
}

}  // namespace cairn
