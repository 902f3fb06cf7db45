// Folders of photos become a reconstruction on Earth: all of `cairn map` but the publication.
#ifndef CAIRN_MAPPING_SESSION_MAP_PHOTOS_H_
#define CAIRN_MAPPING_SESSION_MAP_PHOTOS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/adjust/adjust.h"
#include "core/camera.h"
#include "core/features/sift/sift_extractor.h"
#include "core/geoid.h"
#include "ingest/place/georegister.h"
#include "mapping/growth/grow_segments.h"
#include "mapping/matching/two_view.h"
#include "mapping/pairs/find_pairs.h"
#include "mapping/photos/read_photos.h"
#include "mapping/session/place_segment.h"

namespace cairn {

// The stages' own options. Their numbers of threads do not count.
struct MappingOptions {
  // As many features as COLMAP 3.8's models of facades_strecha have, with which the accuracy of
  // this way is compared. The map keeps fewer.
  SiftOptions sift = {.max_features = 4000};
  PairOptions pairs;
  TwoViewOptions two_views;
  GrowthOptions growth;
  AdjustOptions adjust;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

struct MapPhotosInput {
  std::vector<std::string> paths;  // Folders and files.
  std::vector<Camera> cameras;     // Known intrinsics; see GroupCameras.
  std::string positions_path;      // CSV as of ReadCameraPositions; empty: the photos' EXIF.
  // All folders whose photos the CSV has; there the names of photos begin with those of the folders
  // if there are several. Empty: `paths`.
  std::vector<std::string> table_paths;
  double gps_accuracy_m = 5.0;  // Of EXIF positions that state none: 68 % radius.
  // Of the heights; unset: sea level for EXIF, the ellipsoid for a CSV.
  std::optional<HeightReference> height;
  std::optional<double> camera_height_m;  // Of positions without a height.
  std::string work_dir;                   // Empty: nothing is kept.
  // As ReadPhotosOptions::descriptors. The model, too, then has its descriptors there.
  std::shared_ptr<DescriptorFile> descriptors;
  // Segments that their positions do not place are kept for a map to place
  // (MappedPhotos::unplaced).
  bool keeps_unplaced = false;
  int num_threads = 1;  // The result does not depend on it.
};

struct StageCost {
  std::string name;
  double seconds = 0.0;
  double processor_seconds = 0.0;  // Of all threads, in the program and in the kernel.
  double peak_megabytes = 0.0;     // Of the process so far.
  bool from_work = false;          // The work folder had the result, or all parts of it.
};

// A segment of the photos and what became of it.
struct SegmentReport {
  int num_photos = 0;
  std::string problem = {};  // Why it is not in the model; empty if it is.
  // If true, `georegistration` has the answers of a map in place of positions, and there is no
  // `adjustment`.
  bool is_placed_by_map = false;
  Georegistration georegistration = {};
  AdjustReport adjustment = {};
  // How far the map moved it from where it was placed, at the middle of its cameras. 0 for a
  // session of one segment that its positions place, which moves as a whole.
  double moved_by_map_m = 0.0;
};

// What was found out about a camera of the set.
struct CameraReport {
  Camera camera;  // As adjusted.
  double focal_before_px = 0.0;
  FocalSource source = FocalSource::kGuess;
  int num_photos = 0;  // In the model.
};

// A segment whose positions do not place it: they are fewer than three, do not tell its scale or
// which way is up, or do not fit it. Or one that a map did not anchor where they place it.
struct UnplacedSegment {
  Segment segment;           // With descriptors.
  int number = 0;            // In MappedPhotos::segments.
  std::string problem = {};  // Why it is not placed.
  std::vector<CameraReport> cameras;
  std::vector<std::optional<Geodetic>> positions;  // Of its images; heights above the ellipsoid.
  bool has_place = false;  // Its positions place it, where a map did not anchor it.
};

struct MappedPhotos {
  // All segments that have a place, in one frame: east-north-up at `ecef_from_world`'s origin. The
  // positions alone place them beside each other.
  Reconstruction model;
  std::vector<int> segment_of_image;  // Of the model's images: the number in `segments`.
  std::vector<int> photo_of_image;    // Of the model's images: the photo of the set.
  Sim3d ecef_from_world;
  // Of the largest placed segment; but `accuracy`, `stated_accuracy_m` and `median_residual_m` are
  // the worst of the placed segments.
  Georegistration georegistration;
  std::vector<SegmentReport> segments;  // Largest first.
  std::vector<UnplacedSegment> unplaced;
  std::vector<CameraReport> cameras;
  std::vector<LeftOutPhoto> left_out;
  std::vector<std::string> notes;
  std::vector<StageCost> stages;
  int num_photos = 0;  // Files that were found.
  int num_mapped = 0;  // Photos of the model.
  // For pictures: where the positions are that were used, in the model's world, by photo of the
  // set; and whether the photo is in the model.
  std::vector<std::optional<Eigen::Vector3d>> position_of_photo;
  std::vector<std::optional<Eigen::Vector3d>> center_of_photo;
};

// Receives the phase, the steps done and the total. A step that takes long reports as a phase of
// its own, whose name begins with that of the phase and ": "; the phase goes on after it. One
// thread at a time.
using MapProgress = std::function<void(const char* phase, int64_t done, int64_t total)>;

// Reads photos, finds pairs, matches them, grows segments, places them on Earth. With a work
// folder, a second run with the same input goes on where the first was killed, with the same
// result. Throws Error(kBadInput), with what to do, if fewer than three photos can be read or have
// a position, if no three photos show the same, or if no segment can be placed, then for the
// reason of the largest one, unless `keeps_unplaced` and one has a position; what ReadPhotos and
// WorkFolder throw.
MappedPhotos MapPhotos(const MapPhotosInput& input, const MappingOptions& options,
                       const GeoregisterOptions& georegister, const MapProgress& progress = {});

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_MAP_PHOTOS_H_
