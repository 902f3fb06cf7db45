// What is known of how people hold cameras, walk and fly before any photo is seen: the priors of
// UpEvidence.
#ifndef CAIRN_INGEST_PLACE_UP_PRIORS_H_
#define CAIRN_INGEST_PLACE_UP_PRIORS_H_

#include "ingest/place/up_evidence.h"

namespace cairn {

// Photos of one walk are alike: the tenth forward view says no more than the first nine. So all
// photos of a session count as this many independent ones.
inline constexpr double kIndependentViews = 10.0;

// Sine of the pitch of photos that people take: normal about a pitch that the photos of a session
// share, with a share of any pitch.
inline constexpr double kPitchSigma = 0.2, kWildPitchShare = 0.2;
// The shared pitch: most sessions look ahead, one in ten looks down as steeply as it likes, and few
// look up so.
inline constexpr double kSharedPitchSigma = 0.25, kSteepPitchSigma = 0.6;
inline constexpr double kSteepDownShare = 0.1, kSteepUpShare = 0.02;
inline constexpr double kMaxSharedPitch = 0.95;
// Rolls beyond the standard deviation of a careful hand.
inline constexpr double kWildRollShare = 0.1, kWildRollFactor = 3.0;
// The error of a camera that is meant to look straight down. Its density has the same maximum as
// that of the other ways, so that no way wins because its photos are alike.
inline constexpr double kDownSigmaRad = 0.165;
// The error of an accelerometer in a moving hand, and the share of photos in which it is useless.
inline constexpr double kGravitySigmaRad = 0.1, kBadGravityShare = 0.1;

// The prior of a session's holds: Dirichlet with these means, in the order of PictureUp, at last
// any other. So weak a prior (half a photo) says that most sessions are of one kind. No way is
// twenty times as likely as the opposite one, so this prior alone never decides (the default of
// least_up_odds).
inline constexpr HoldShares kHoldPrior = {0.45, 0.35, 0.08, 0.03, 0.05, 0.04};
inline constexpr double kHoldPriorWeight = 0.5;
inline constexpr int kShareRounds = 6;

// What a session's orientations say if they say nothing: programs that do not know write 1, and a
// phone whose rotation is locked, the way it was held before.
inline constexpr HoldShares kMadeUp = {0.9, 0.02, 0.003, 0.003};
inline constexpr double kMadeUpMixed = 0.01;
// What a sensor says that looks straight down: the way it was held before.
inline constexpr HoldShares kSaidFromAbove = {0.5, 0.4, 0.05, 0.05};
inline constexpr double kSaidFromAboveMixed = 0.1;

// The shape of a reconstruction drifts by about a hundredth of its extent, so positions that are
// better than that do not make a bend of it significant.
inline constexpr double kShapeError = 0.01;

// Slopes of walks, root mean square of heights over that of horizontal distances, and the share of
// sessions that climb in any way.
inline constexpr double kSlopeSigma = 0.1, kClimbShare = 0.03;

// A ray goes far below if it ends this far below the camera, and steeply enough that errors of up
// do not matter. People hold a camera at 1 to 2 m over the ground. On real walks, up to 0.1 % of
// the rays go far below with the true up, and 4 to 45 % with an up that is turned by 90 or 180
// degrees (docs/math/localization.md).
inline constexpr double kFarM = 3.0, kSteepSine = 0.17;
inline constexpr double kFewFar = 0.01, kManyFar = 0.04;
// Share of the sessions that are photographed from bridges, balconies or hills, and of these, the
// share of those under a low roof, beyond which they see nothing.
inline constexpr double kHighSessionShare = 0.03, kLowRoofShare = 0.03;
// Cameras that look straight down fly, or a person films the floor. They are rarely between.
inline constexpr double kLeastFlightM = 10.0, kLargestFloorM = 3.5;
inline constexpr double kLowFlightShare = 1e-3, kUnseenFlightShare = 0.1;
// Share of the level sessions that see nothing beyond kLargestFloorM: they go along a wall at arm's
// length, which on a line looks as a floor does from above.
inline constexpr double kCloseWallShare = 0.1;

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_UP_PRIORS_H_
