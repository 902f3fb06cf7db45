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
  // Reprojection error of the known landmark in the session's images, median over the images. The
  // unit is the standard deviation that the keypoint, the landmark and the placement give together.
  double max_error_sigmas = 4.0;
  double keypoint_sigma_px = 1.5;  // At a focal length of 500 px; proportional to the focal length.
  // Only looks from similar directions, of similar physical size and orientation are compared.
  double max_azimuth_rad = 1.2;
  double max_log2_size = 1.5;
  double max_orientation_rad = 0.6;
  // Median over the session's looks of the distance to the nearest look of the known landmark, as
  // quantile of distances between looks at one landmark.
  double max_distance_quantile = 0.95;
  // Largest ratio of the squared descriptor distance to that of another thing nearby.
  double max_ratio = 0.85;

  void Validate() const;
};

// A landmark of the session may be one of the map.
struct LinkProposal {
  uint32_t landmark_idx = 0;  // In PlacedSession::landmarks.
  LandmarkId known_id{};
  float sq_distance = 0.0f;  // Of the descriptors; smaller is better.
};

// Compares the landmarks that the session's images of one tile see with the landmarks of the map's
// tile `known`. Returns at most one proposal for each landmark of the session. Linear in the tile
// and the session's sights of it.
std::vector<LinkProposal> ProposeLinks(const Reconstruction& reconstruction,
                                       const PlacedSession& session, const Tile& known,
                                       const DescriptorCodec& codec, const LinkOptions& options);

// Returns the id of the map's landmark for each landmark of the session, or 0. Accepts proposals in
// the order of their distances.
// Two landmarks of the session get the same id only if no image sees both.
std::vector<LandmarkId> ResolveLinks(const Reconstruction& reconstruction,
                                     const PlacedSession& session,
                                     std::vector<LinkProposal> proposals);

// Returns the session with landmarks of equal id (except 0) joined into one, at the mean position
// by inverse variances. `ids` stays parallel to the landmarks.
PlacedSession JoinLinked(const PlacedSession& session, std::vector<LandmarkId>* ids);

}  // namespace cairn

#endif  // CAIRN_INGEST_MERGING_LINK_LANDMARKS_H_
