// Grows segments from photos: seeds of three photos, then rounds in which the photos that see a
// segment join it; then segments that show the same become one.
#ifndef CAIRN_MAPPING_GROWTH_GROW_SEGMENTS_H_
#define CAIRN_MAPPING_GROWTH_GROW_SEGMENTS_H_

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/adjust/adjust.h"
#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"
#include "mapping/segment.h"

namespace cairn {

struct GrowthOptions {
  // A photo joins a segment with at least this many keypoints that see landmarks, and stays with as
  // many after triangulation and adjustment.
  int min_inliers = 20;
  // A photo waits while its inliers are less than this share of those of its strongest two view
  // with a photo that is not in the segment: the segment comes to it along strong links. A facade
  // that repeats gives wrong photos at most a twentieth, right ones a tenth and more (decision 47).
  double min_link_share = 0.1;
  // Photos of the segment whose two views must agree with the pose of a photo that joins; the
  // agreeing ones must also have more inliers than those that contradict.
  int min_witnesses = 2;
  // How far the rotation and the direction to a photo may differ from a two view, unless its own
  // standard deviations allow more (three of them).
  double max_rotation_error_rad = 0.035;   // 2 degrees.
  double max_direction_error_rad = 0.087;  // 5 degrees.
  // Accuracy of a GPS position that does not state it.
  double default_gps_accuracy_m = 15.0;
  // A segment is adjusted each time when it has grown by this share: as a whole up to 200 photos,
  // and beyond, by this share of 200, where it grew.
  double adjust_after_growth = 0.33;
  // Photos that a segment needs. Fewer photos have no one to contradict them.
  int min_photos = 3;
  uint64_t seed = 1;
  int num_threads = 1;  // The result does not depend on it.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Why a photo is in a segment or not.
enum class PhotoVerdict : uint8_t {
  kInSegment,
  kNoTwoView,       // No other photo shows enough of the same.
  kNoSeed,          // It sees the same as others, but no three photos of them determine a start.
  kTooFewInliers,   // Too few of its keypoints see landmarks of the segment.
  kWeakSupport,     // Its links to photos outside of the segment are much stronger.
  kContradicted,    // The two views with photos of the segment do not agree with its pose.
  kGpsContradicts,  // Its position is far from where the segment has it.
  kLostSupport,     // It was in the segment; its landmarks did not survive the adjustment.
};
// A sentence for the report of a map.
const char* ExplainVerdict(PhotoVerdict verdict);

struct Growth {
  std::vector<Segment> segments;               // The one with the most photos first.
  std::vector<PhotoVerdict> verdict_of_photo;  // Of each photo of the set.
};

// Receives the photos that are in segments so far and the number of photos.
using GrowthProgress = std::function<void(int num_in_segments, int num_photos)>;

// `views` are the two views of the set. Each photo is in at most one segment. `adjustment` follows
// each adjustment of a whole segment. Deterministic.
Growth GrowSegments(const PhotoSet& set, std::span<const TwoView> views,
                    const GrowthOptions& options, const GrowthProgress& progress = {},
                    const AdjustProgress& adjustment = {});

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_GROW_SEGMENTS_H_
