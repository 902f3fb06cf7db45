// A segment while it grows.
#ifndef CAIRN_MAPPING_GROWTH_DRAFT_H_
#define CAIRN_MAPPING_GROWTH_DRAFT_H_

#include <span>
#include <vector>

#include "core/adjust/adjust.h"
#include "mapping/growth/localize_photo.h"
#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"
#include "mapping/segment.h"

namespace cairn {

// The keypoints of all photos that the two views join to points. Immutable.
struct TrackTable {
  // Observations refer to photos, at most one a photo.
  std::vector<std::vector<ReconObservation>> tracks;
  std::vector<std::vector<int>> track_of_keypoint;  // [photo][keypoint]; -1: none.

  TrackTable(const PhotoSet& set, std::span<const TwoView> views);
};

// The photos that joined so far and the landmarks that they see. A landmark is the part of a track
// whose observations agree with the poses. Not thread-safe.
class Draft {
 public:
  // Keeps references to the set and the tracks. `cameras` are those of the set, perhaps adjusted
  // before. `num_threads` does not change results.
  Draft(const PhotoSet& set, const TrackTable& tracks, std::vector<Camera> cameras,
        int num_threads);

  // Goes on from a finished segment, in its world.
  Draft(const PhotoSet& set, const TrackTable& tracks, const Segment& segment, int num_threads);

  int num_photos() const { return static_cast<int>(photo_of_image_.size()); }
  const std::vector<int>& photos() const { return photo_of_image_; }  // In the order of joining.
  bool Has(int photo) const { return image_of_photo_[photo] >= 0; }
  const Rigid3d& PoseOf(int photo) const {
    return model_.images[image_of_photo_[photo]].cam_from_world;
  }
  const Camera& CameraOf(int photo) const { return model_.cameras[set_.photos[photo].camera_idx]; }
  // True if no photo of this camera has joined, so that nothing is known of it but the prior.
  bool IsNewCamera(int camera_idx) const;
  void SetCamera(int camera_idx, const Camera& camera) { model_.cameras[camera_idx] = camera; }

  // The landmarks that the keypoints of a photo outside of the draft see by their tracks.
  std::vector<LandmarkObservation> ObservationsOf(int photo) const;
  // Observations of each photo of the draft; 0 for others.
  std::vector<int> CountObservations() const;

  // Adds a photo without observations.
  void Add(int photo, const Rigid3d& cam_from_world);
  // The same with the camera under which the photo was localized, if no other has this camera.
  void Add(int photo, const LocalizedPhoto& localized);
  // Removes photos; landmarks with fewer than two observations leave with them.
  void Remove(std::span<const int> photos);
  // Observes and triangulates the tracks that these photos see.
  void Triangulate(std::span<const int> photos);
  // Adjusts the poses of these photos and the landmarks they see; the rest stays. False, and
  // nothing changes, if the solver fails.
  bool AdjustAround(std::span<const int> photos);
  // Adjusts everything and triangulates what agrees only then. Guessed focal lengths are always
  // adjusted; those of EXIF, and distortions, only if `is_final` and enough photos have the camera.
  // False if the solver fails; nothing changes then, unless a focal length that strayed had been
  // reset.
  bool AdjustAll(bool is_final = false, const AdjustProgress& progress = {});

  // The photos in the order of the set.
  Segment Finish() const;

 private:
  void IndexLandmarks();  // Fills landmark_of_track_.
  int TrackOf(const ReconLandmark& landmark) const;
  std::vector<int> TracksSeenBy(std::span<const int> photos) const;
  std::optional<ReconLandmark> MakeLandmark(int track) const;
  // Puts cameras back to their EXIF that left it by far, and holds them there. True if there were
  // any.
  bool HoldStrayCameras();
  Reconstruction Surroundings(std::span<const int> photos, std::vector<int>* image_of_part,
                              std::vector<int>* landmark_of_part) const;

  const PhotoSet& set_;
  const TrackTable& tracks_;
  int num_threads_;
  Reconstruction model_;
  std::vector<int> photo_of_image_;
  std::vector<int> image_of_photo_;     // -1: not in the draft.
  std::vector<int> landmark_of_track_;  // -1: none.
  std::vector<uint8_t> is_held_;        // Of each camera.
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_DRAFT_H_
