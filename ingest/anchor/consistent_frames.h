// The batch filter: which of the localized photos of a session are right.
#ifndef CAIRN_INGEST_ANCHOR_CONSISTENT_FRAMES_H_
#define CAIRN_INGEST_ANCHOR_CONSISTENT_FRAMES_H_

#include <vector>

#include "core/rigid3.h"
#include "ingest/anchor/pose_pair.h"

namespace cairn {

struct ConsistencyOptions {
  // Standard deviations of each pose beside the accuracy that the engine states: errors that a
  // session leaves between neighboring photos.
  double position_sigma_m = 0.1;
  double rotation_sigma_rad = 0.005;
  // Standard deviation of the drift of a session between two photos, by their distance: twice that
  // of good odometry.
  double drift_share = 0.005;
  // Standard deviation of the drift of rotations between photos 60 m apart or more; between nearer
  // ones in proportion to their distance.
  double drift_rad = 0.02;
  // Relative standard deviation of the session's size. GPS receivers of phones tell the size of a
  // street to 3 %.
  double scale_sigma = 0.03;
  // Two photos are consistent up to the 0.99 quantile of chi-squared with six degrees of freedom.
  double max_chi_sq = 16.81;
};

// What a set of frames that agree with each other weighs.
struct FrameSet {
  int num_frames = 0;
  // Places more than 0.3 m apart: frames of one place share their mistakes and count once.
  int num_places = 0;
  double extent_m = 0.0;  // Largest distance of two frames along an axis of the Earth's frame.
};

struct ConsistentFrames {
  std::vector<bool> agrees;    // Of each pair.
  FrameSet winner;             // All frames that agree.
  FrameSet rival;              // The largest group that agrees on something else.
  std::vector<bool> is_rival;  // Of each pair.
  // A rival of at least five places stands 60 m apart from the frames that agree, where nothing
  // speaks against it.
  bool rival_is_apart = false;
};

// Compares the relative poses of frames in the session with those in the map: they do not depend on
// where the session is thought to stand, how it is turned, or on drift far away. Frames within 60 m
// of each other are grouped (GroupFrames), and the group of most places wins. Another group of
// two or more frames
//  - is an island if it stands 60 m apart from all frames accepted so far, and most of its pairs
//    with the winner agree up to the drift. It is accepted if it has `kIslandPlaces` places and no
//    group of half as many stands near it;
//  - is a rival otherwise.
// The frames accepted tell the size of the session, in which all are compared again.
// Takes 2 ms for 84 frames. docs/math/mapping_sessions.md has the formulas.
ConsistentFrames FindConsistentFrames(const std::vector<PosePair>& pairs,
                                      const ConsistencyOptions& options);

inline constexpr int kIslandPlaces = 10;

// Places of the cameras of a session; stops counting at `limit`.
int CountPlaces(const std::vector<Rigid3d>& cam_from_ecef, int limit);
double ExtentM(const std::vector<Rigid3d>& cam_from_ecef);

// What a session is, and what of it the map recognizes.
struct AnchorEvidence {
  int num_answers = 0;  // Photos that the map localized.
  FrameSet winner, rival;
  bool rival_is_apart = false;
  FrameSet session;  // All photos of the session; num_places up to 2 * kIslandPlaces.
};

// A session is anchored if the frames that agree
//  - stand in ten places, or half of those of a session with fewer than twenty, three at least;
//  - reach over 10 m, or half of the session if that is less;
//  - are a fifth of those localized;
//  - have no rivals in half as many places, and none that are apart from them.
bool IsAnchored(const AnchorEvidence& evidence);
int PlacesNeeded(const AnchorEvidence& evidence);
double ExtentNeededM(const AnchorEvidence& evidence);

}  // namespace cairn

#endif  // CAIRN_INGEST_ANCHOR_CONSISTENT_FRAMES_H_
