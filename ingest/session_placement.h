// Where a session stands once the map has been asked. Private to ingest.
#ifndef CAIRN_INGEST_SESSION_PLACEMENT_H_
#define CAIRN_INGEST_SESSION_PLACEMENT_H_

#include <string>
#include <vector>

#include "ingest/ingest_options.h"
#include "ingest/place/ask_keyframes.h"
#include "ingest/place/compare_with_map.h"
#include "ingest/tiles/placed_session.h"
#include "storage/map/map_store.h"

namespace cairn {

// Which landmarks of a session are good enough.
PlacementOptions PlacementOf(const IngestOptions& options);

// How well the positions on Earth are known: radii that contain 68 % of them, meters; 0: unknown.
struct PositionAccuracies {
  double session_m = 0.0;
  double map_m = 0.0;
};

// The accuracy of a session's positions is what was stated or what the residuals of the
// georegistration show, whichever is worse. The residuals tell that of the sessions of the map: the
// worst of those with keyframes in the tiles of the session, or of all if there are none.
PositionAccuracies AccuracyOf(const MapComparison& comparison, double stated_m,
                              double median_residual_m, const std::vector<SessionRecord>& map);

// The motion that a session may make to follow the map.
struct MotionLimits {
  double moved_m = 0.0;  // A motion upward counts half if positions are inaccurate.
  double turned_rad = 0.0;
  double scale_change = 0.0;
  bool follow_accuracy = false;  // Larger than those of the options.
};

// Returns the limits of the options. If at least five photos and four in five of the recognized
// ones agree within 0.3 m, the motion is sure, and the limits grow to what positions of this
// accuracy exceed once in 300 times: 3.4 standard deviations of an axis. Errors of positions turn
// and resize a session by the error over its spread, and the map likewise by that of the session
// that placed it there.
MotionLimits LimitsOf(const MapComparison& comparison, const AgreementOptions& options,
                      const PositionAccuracies& accuracy);

// Throws SessionRefused, with the figures of the disagreement and what to do, if a session or
// another map contradicts the map: the map recognizes none of its photos, or recognizes them
// mirrored, elsewhere, turned, of another size, in places that fit no motion, or in two groups that
// contradict each other; or if it is not anchored, as AgreementOptions::unanchored asks for.
// `newcomer` names it.
void RequireAgreement(const MapComparison& comparison, const AgreementOptions& options,
                      const PositionAccuracies& accuracy, const std::string& newcomer);

// Throws SessionRefused, with the figures and what to do, if the answers lost are more than two
// and more than the options allow. `newcomer` names what the update adds.
void RequireAnswers(const KeyframeAnswers& answers, const GateOptions& options,
                    const std::string& newcomer);

// The session moved to where the map sees it and bent as it says, or as it is if the map recognizes
// too few photos. Landmarks move with the cameras that see them. Writes how far the session bends.
PlacedSession SettleSession(PlacedSession session, const Reconstruction& reconstruction,
                            MapComparison* comparison);

}  // namespace cairn

#endif  // CAIRN_INGEST_SESSION_PLACEMENT_H_
