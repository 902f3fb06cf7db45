// Finds the landmarks of a new session that the map has already.
#ifndef CAIRN_INGEST_TILES_LINK_LANDMARKS_H_
#define CAIRN_INGEST_TILES_LINK_LANDMARKS_H_

#include <cstdint>
#include <vector>

#include "core/scene/reconstruction.h"
#include "ingest/tiles/placed_session.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// Limits within which two landmarks are linked. They are strict, because a false link does more
// harm than a missed link.
struct LinkOptions {
  // Standard deviation of the session's placement in the map, meters an axis.
  double placement_sigma_m = 0.05;
  // Largest distance between the positions, in standard deviations of their difference.
  double max_distance_sigmas = 6.0;
  // Largest reprojection error of the known landmark in the session's images (median over the
  // images), in standard deviations. Keypoint, landmark and placement contribute to the deviation.
  double max_error_sigmas = 4.0;
  double keypoint_sigma_px = 1.5;  // At a focal length of 500 px; proportional to the focal length.
  // Two observations are compared only if their directions, sizes and orientations differ by less.
  double max_azimuth_rad = 1.2;
  double max_log2_size = 1.5;
  double max_orientation_rad = 0.6;
  // Largest descriptor distance to the nearest descriptor of the known landmark (median over the
  // session's observations), as a quantile of the distances between descriptors of one landmark.
  double max_distance_quantile = 0.95;
  // Largest ratio of the squared descriptor distance to that of any other known landmark nearby.
  double max_ratio = 0.85;

  void Validate() const;
};

// A landmark of the session that may be a landmark of the map.
struct LinkProposal {
  uint32_t landmark_idx = 0;  // In PlacedSession::landmarks.
  LandmarkId known_id{};
  float sq_distance = 0.0f;  // Of the descriptors; smaller is better.
};

// Compares the landmarks that the session's images of one tile see with the landmarks of the map's
// tile `known`. Returns at most one proposal for each landmark of the session. Linear in the tile
// and the session's observations of it.
std::vector<LinkProposal> ProposeLinks(const Reconstruction& reconstruction,
                                       const PlacedSession& session, const Tile& known,
                                       const DescriptorCodec& codec, const LinkOptions& options);

// Returns the id of the map's landmark for each landmark of the session, or 0. Accepts proposals in
// the order of their distances. Two landmarks of the session get the same id only if no image sees
// both.
std::vector<LandmarkId> ResolveLinks(const Reconstruction& reconstruction,
                                     const PlacedSession& session,
                                     std::vector<LinkProposal> proposals);

// Returns the session with landmarks of equal id (except 0) joined into one, at the mean position
// by inverse variances. `ids` stays parallel to the landmarks.
PlacedSession JoinLinked(const PlacedSession& session, std::vector<LandmarkId>* ids);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_LINK_LANDMARKS_H_
