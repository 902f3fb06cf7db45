// Whether a photo may join a draft, and with which pose.
#ifndef CAIRN_MAPPING_GROWTH_PROPOSE_PHOTO_H_
#define CAIRN_MAPPING_GROWTH_PROPOSE_PHOTO_H_

#include <cstdint>
#include <optional>

#include "mapping/growth/draft.h"
#include "mapping/growth/gps_check.h"
#include "mapping/growth/grow_segments.h"
#include "mapping/growth/localize_photo.h"
#include "mapping/growth/view_graph.h"
#include "mapping/photo_set.h"

namespace cairn {

// The pose that a photo would have in a draft, or the reason why it has none.
struct Proposal {
  int photo = 0;
  int num_observations = 0;
  PhotoVerdict verdict = PhotoVerdict::kTooFewInliers;
  std::optional<LocalizedPhoto> pose;
};

// Keeps references to its arguments. Immutable, and safe to use from several threads.
class Proposer {
 public:
  Proposer(const PhotoSet& set, const ViewGraph& graph, const GrowthOptions& options)
      : set_(set), graph_(graph), options_(options) {}

  // What the two views of a photo with those of the draft say about a pose.
  Testimony AskAbout(const Draft& draft, int photo, const Posed& posed) const;

  // True if the positions contradict the pose and it is not the photo's own position that is wrong.
  // They need to say less if two views contradict, too.
  bool IsElsewhere(const Draft& draft, const GpsCheck& gps, const Testimony& testimony, int photo,
                   const Rigid3d& cam_from_world) const;

  // Localizes a photo, without the rules of acceptance.
  Proposal Localize(const Draft& draft, int photo) const;

  // Localizes a photo and applies the rules of acceptance. As a last resort, a photo with stronger
  // links to the outside joins if its place explains why those to the draft are weak: no photo of
  // the draft shows the same from nearly the same place, and three or more two views agree, with
  // four times the inliers of those that contradict.
  Proposal Propose(const Draft& draft, const GpsCheck& gps, int photo, bool is_last_resort) const;

 private:
  bool IsBeyondDoubt(const Testimony& testimony) const;
  // True if the photos that show the same as this one were taken, by their own positions, where its
  // pose is and not where its position is. At another copy of a facade, those with the strongest
  // links are near its position.
  bool IsPositionWrong(const Draft& draft, const GpsCheck& gps, const Testimony& testimony,
                       int photo, const Rigid3d& cam_from_world) const;
  // True if a photo of the draft shows what this pose sees from nearly the same place, and so
  // should have a strong link with the photo. At a wrong copy of a facade, there is one.
  bool LooksLikeOneOf(const Draft& draft, int photo, const LocalizedPhoto& pose) const;
  // True for two photos that nobody can tell apart by where they were taken: an edited copy and its
  // original, or two of a burst. Neither is the way by which a segment comes to the other.
  bool IsSamePicture(const TwoView& view) const;
  // Inliers of the photo's strongest two view with a photo outside of the draft that does not show
  // the same picture.
  int StrongestLinkOutside(const Draft& draft, int photo) const;
  uint64_t SeedOf(int photo, int num_photos) const;

  const PhotoSet& set_;
  const ViewGraph& graph_;
  const GrowthOptions& options_;
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_PROPOSE_PHOTO_H_
