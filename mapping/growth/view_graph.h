// The two views of a set by photo, and what they say about poses.
#ifndef CAIRN_MAPPING_GROWTH_VIEW_GRAPH_H_
#define CAIRN_MAPPING_GROWTH_VIEW_GRAPH_H_

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "mapping/growth/grow_segments.h"
#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn {

// How far two poses differ from a two view.
struct ViewErrors {
  double rotation_rad = 0.0;
  double direction_rad = 0.0;  // Of the translation.
};

// How far they may differ.
struct ViewTolerances {
  double rotation_rad = 0.0;
  double direction_rad = 0.0;
};

ViewErrors CompareWithView(const TwoView& view, const Rigid3d& a_from_world,
                           const Rigid3d& b_from_world);

// What the two views of a photo say about a pose of it.
struct Testimony {
  int num_witnesses = 0;  // Two views that agree.
  int agreeing_inliers = 0;
  int contradicting_inliers = 0;
};

// A photo's pose and camera, which must outlive it.
struct Posed {
  const Rigid3d& cam_from_world;
  const Camera& camera;
};

// Keeps references to its arguments. Immutable.
class ViewGraph {
 public:
  ViewGraph(const PhotoSet& set, std::span<const TwoView> views, const GrowthOptions& options);

  const std::vector<int>& ViewsOf(int photo) const { return views_of_photo_[photo]; }
  const TwoView& View(int view) const { return views_[view]; }
  int OtherOf(int view, int photo) const {
    return views_[view].a == photo ? views_[view].b : views_[view].a;
  }
  // The index of the two view of two photos; -1 if there is none.
  int Find(int photo, int other) const;

  // The tolerances of the options, or three standard deviations of the view if they are larger. A
  // guessed focal length bends rotations and directions, so its views may differ more.
  ViewTolerances TolerancesOf(const TwoView& view) const;
  // True if the view knows its direction well enough to tell a wrong pose.
  bool CanTestify(const TwoView& view) const;
  // True if a focal length of the view is or was a guess.
  bool IsGuessed(const TwoView& view) const;

  // True if most inliers of a view fit the poses as well as those of a draft do (kMaxDraftSigmas).
  bool MostInliersFit(const TwoView& view, const Posed& a, const Posed& b) const;

  // Asks the views of `photo` with photos that have a pose. A view agrees if rotation and direction
  // do, within its tolerances. Where a focal length was a guess, both were found under a camera
  // that has changed since; then a view agrees if most of its inliers fit the poses under these
  // cameras.
  Testimony Ask(int photo, const Posed& posed,
                const std::function<std::optional<Posed>(int photo)>& posed_of) const;

 private:
  bool Agrees(const TwoView& view, const Posed& a, const Posed& b) const;

  const PhotoSet& set_;
  std::span<const TwoView> views_;
  const GrowthOptions& options_;
  std::vector<std::vector<int>> views_of_photo_;  // Ascending.
};

// Three photos whose two views agree with each other: a start of a segment.
struct Seed {
  int base_view = 0;  // The pair with the largest parallax.
  int third = 0;      // A photo.
  double score = 0.0;
};

// All closed triplets of photos, best first: rotations close, and the directions of the three
// translations lie in one plane in the right order, within the tolerances of the views. The score
// is the smallest number of inliers times the parallax of the base, up to kEnoughParallaxRad.
std::vector<Seed> FindSeeds(const ViewGraph& graph, int num_photos);

// With more parallax, a seed is not more certain, but its photos look less alike.
inline constexpr double kEnoughParallaxRad = 0.14;

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_VIEW_GRAPH_H_
