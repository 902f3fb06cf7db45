// Which landmarks of a new session are landmarks that the map has already.
#ifndef CAIRN_INGEST_MERGING_LINK_LANDMARKS_H_
#define CAIRN_INGEST_MERGING_LINK_LANDMARKS_H_

#include <cstdint>
#include <vector>

#include "ingest/sfm/reconstruction.h"
#include "ingest/tiling/placed_session.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// What two landmarks must have in common. A false link is worse than a missed one.
struct LinkOptions {
  // Standard deviation of the session against the map after its placement, metres an axis.
  double placement_sigma_m = 0.05;
  // Distance of the positions, in standard deviations of their difference.
  double max_distance_sigmas = 6.0;
  // The known landmark, seen from the session's keyframes, in standard deviations of the keypoint's
  // error (max_error_px at a focal length of 500, the landmark's own uncertainty, the placement);
  // median over the keyframes.
  double max_error_sigmas = 4.0;
  double keypoint_sigma_px = 1.5;
  // Only looks from similar directions, of similar physical size and orientation are compared.
  double max_azimuth_rad = 1.2;
  double max_log2_size = 1.5;
  double max_orientation_rad = 0.6;
  // Median over the session's looks of the distance to the nearest look of the known landmark, as
  // quantile of distances between looks at one landmark.
  double max_distance_quantile = 0.95;
  // The second best candidate must be so much farther in squared descriptor distance.
  double max_ratio = 0.85;

  void Validate() const;
};

// A landmark of the session may be one of the map.
struct LinkProposal {
  uint32_t landmark_idx = 0;  // In PlacedSession::landmarks.
  LandmarkId known_id{};
  float sq_distance = 0.0f;  // Of the descriptors; smaller is better.
};

// Proposals for what the session's images of one tile see, against what the map holds of the tile.
// At most one for each landmark of the session. Linear in the tile and the session's sights of it.
std::vector<LinkProposal> ProposeLinks(const Reconstruction& reconstruction,
                                       const PlacedSession& session, const Tile& known,
                                       const DescriptorCodec& codec, const LinkOptions& options);

// The id of the map's landmark for each landmark of the session, or 0. Better proposals come first.
// Two landmarks of the session get the same id only if no image sees both.
std::vector<LandmarkId> ResolveLinks(const Reconstruction& reconstruction,
                                     const PlacedSession& session,
                                     std::vector<LinkProposal> proposals);

// The session with the landmarks of equal id (not 0) made one, at the mean position by inverse
// variances; `ids` shrinks along.
PlacedSession JoinLinked(const PlacedSession& session, std::vector<LandmarkId>* ids);

}  // namespace cairn

#endif  // CAIRN_INGEST_MERGING_LINK_LANDMARKS_H_
