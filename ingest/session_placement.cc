#include "ingest/session_placement.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "core/angles.h"
#include "core/error.h"

namespace cairn {
namespace {

[[noreturn]] void Refuse(const std::string& newcomer, const std::string& figures) {
  throw Error(ErrorCode::kConflict,
              fmt::format("{} contradicts the map: {}. Correct its georegistration, or "
                          "keep it apart from what the map knows (--apart)",
                          newcomer, figures));
}

}  // namespace

void RequireAgreement(const MapComparison& comparison, const AgreementOptions& limits,
                      const std::string& newcomer) {
  const PlacementFit& fit = comparison.fit;
  const bool should_know = comparison.num_expected >= limits.min_expected;
  if (should_know &&
      comparison.num_localized < limits.min_recognized_share * comparison.num_expected) {
    Refuse(newcomer,
           fmt::format("of {} photos that stand where the map has photos that look the same "
                       "way, it recognizes {}",
                       comparison.num_expected, comparison.num_localized));
  }
  if (comparison.num_localized < kLeastPhotosToJudge) {
    return;
  }
  if (fit.num_agreeing < limits.min_agreeing_share * comparison.num_localized) {
    Refuse(newcomer,
           fmt::format("the map recognizes {} of {} photos, but only {} of them in places "
                       "that one motion of the session explains",
                       comparison.num_localized, comparison.num_expected, fit.num_agreeing));
  }
  if (fit.moved_m > limits.max_moved_m || fit.turned_rad > limits.max_turned_rad ||
      std::abs(fit.scale - 1.0) > limits.max_scale_change) {
    Refuse(
        newcomer,
        fmt::format("the map sees {} of its photos {:.2f} m away, turned by {:.1f} degrees and "
                    "{:.3f} times as large (allowed: {:.1f} m, {:.1f} degrees, {:.3f} to {:.3f})",
                    fit.num_agreeing, fit.moved_m, fit.turned_rad * kDegPerRad, fit.scale,
                    limits.max_moved_m, limits.max_turned_rad * kDegPerRad,
                    1.0 - limits.max_scale_change, 1.0 + limits.max_scale_change));
  }
}

PlacedSession SettleSession(PlacedSession session, const MapComparison& comparison,
                            const Reconstruction& reconstruction) {
  if (!IsJudged(comparison)) {
    return session;
  }
  const Sim3d& map_from_session = comparison.fit.map_from_session;
  for (Rigid3d& cam_from_ecef : session.cam_from_ecef) {
    cam_from_ecef = CamFromTarget(cam_from_ecef, map_from_session);
  }
  for (PlacedLandmark& landmark : session.landmarks) {
    landmark.x_in_ecef = map_from_session * landmark.x_in_ecef;
  }
  AssignTiles(reconstruction, &session);
  return session;
}

}  // namespace cairn
