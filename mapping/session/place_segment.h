// Places a segment on Earth and adjusts it once more with the positions of its photos.
#ifndef CAIRN_MAPPING_SESSION_PLACE_SEGMENT_H_
#define CAIRN_MAPPING_SESSION_PLACE_SEGMENT_H_

#include <optional>
#include <span>
#include <vector>

#include "core/adjust/adjust.h"
#include "ingest/place/georegister.h"
#include "mapping/photo_set.h"
#include "mapping/segment.h"

namespace cairn {

// What is known of the photos of a set beside their content; a member for each photo.
struct PhotoPlaces {
  std::vector<std::optional<CameraPosition>> positions;  // Heights above the ellipsoid.
  ImageOrientations orientations;
};

// A segment that fits its photos and their positions.
struct AdjustedSegment {
  Segment segment;  // World is about east-north-up at `origin`, meters.
  Geodetic origin;
  AdjustReport report;
};

// Cameras are as free as in the last adjustment of the growth (FreedomOf); a focal length of EXIF
// that the growth held stays. Throws Error(kBadInput) as Georegister does, and if fewer than three
// photos have a position.
AdjustedSegment AdjustToPositions(const PhotoSet& set, const PhotoPlaces& places, Segment segment,
                                  const GeoregisterOptions& options, const AdjustOptions& adjust,
                                  const AdjustProgress& progress = {});

struct PlacedSegment {
  Segment segment;                  // World is east-north-up at the origin, meters.
  Georegistration georegistration;  // Its ecef_from_world is of the new world.
  AdjustReport adjustment;
};

// An adjustment may turn a straight walk about itself, which its positions do not tell; the cameras
// do. Throws Error(kBadInput) as Georegister does.
PlacedSegment PlaceSegment(const PhotoPlaces& places, AdjustedSegment adjusted,
                           const GeoregisterOptions& options);

// Makes `all` state the worst of its segments: a session has one accuracy for all of them.
void TakeWorst(const Georegistration& segment, Georegistration* all);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_PLACE_SEGMENT_H_
