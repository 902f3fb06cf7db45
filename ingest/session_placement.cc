#include "ingest/session_placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/angles.h"
#include "core/radius68.h"
#include "ingest/session_refused.h"

namespace cairn {
namespace {

[[noreturn]] void Refuse(const std::string& newcomer, const std::string& figures,
                         const std::string& remedy) {
  throw SessionRefused(
      fmt::format("{} contradicts the map: {}. {}, or keep it apart from what the map knows "
                  "(--apart)",
                  newcomer, figures, remedy));
}

constexpr const char* kCorrect = "Correct its georegistration";

// Few photos that agree by and large may still be wrong together: facades repeat.
bool IsSure(const MapComparison& comparison) {
  constexpr int kLeastPhotos = 5;
  constexpr double kLeastShare = 0.8, kMaxResidualM = 0.3;
  const PlacementFit& fit = comparison.fit;
  const bool are_most = fit.num_agreeing >= kLeastPhotos &&
                        fit.num_agreeing >= kLeastShare * comparison.num_recognized();
  const bool are_anchored =
      IsAnchored(comparison.anchoring) && comparison.anchoring.winner.num_places >= kIslandPlaces;
  return (are_most || are_anchored) && fit.median_residual_m <= kMaxResidualM;
}

constexpr const char* kMirrored =
    "Check whether the program that wrote its keypoints, or those of the map, mirrors images";

// Returns the largest motion of a camera.
double BendSession(const Bending& bending, PlacedSession* session) {
  if (bending.is_none()) {
    return 0.0;
  }
  double largest_m = 0.0;
  std::vector<Eigen::Vector3d> sum(session->landmarks.size(), Eigen::Vector3d::Zero());
  std::vector<int> num_views(session->landmarks.size(), 0);
  for (size_t i = 0; i < session->cam_from_ecef.size(); ++i) {
    const Rigid3d before = session->cam_from_ecef[i];
    const Rigid3d ecef_from_cam = bending.Bend(before).Inverse();
    largest_m =
        std::max(largest_m, (ecef_from_cam.translation - before.Inverse().translation).norm());
    for (const PlacedObservation& seen : session->observations_of_image[i]) {
      sum[seen.landmark_idx] +=
          ecef_from_cam * (before * session->landmarks[seen.landmark_idx].x_in_ecef);
      ++num_views[seen.landmark_idx];
    }
    session->cam_from_ecef[i] = ecef_from_cam.Inverse();
  }
  for (size_t i = 0; i < sum.size(); ++i) {
    session->landmarks[i].x_in_ecef = sum[i] / static_cast<double>(num_views[i]);
  }
  return largest_m;
}

bool IsFromBehind(const MapComparison& comparison) {
  const auto are_most = [](int num_from_behind, int num_photos) {
    return num_from_behind >= kLeastPhotosToJudge && 2 * num_from_behind > num_photos;
  };
  return are_most(comparison.num_from_behind, comparison.num_recognized()) ||
         are_most(comparison.num_agreeing_from_behind, comparison.fit.num_agreeing);
}

std::string MirrorNote(const MapComparison& comparison) {
  return IsFromBehind(comparison) ? fmt::format(", and {} from behind, as if seen in a mirror",
                                                comparison.num_from_behind)
                                  : "";
}

void RequireRecognized(const MapComparison& comparison, const AgreementOptions& options,
                       const std::string& newcomer) {
  if (comparison.num_expected >= options.min_expected &&
      comparison.num_localized < options.min_recognized_share * comparison.num_expected &&
      !IsJudged(comparison)) {
    Refuse(newcomer,
           fmt::format("of {} photos that stand where the map has photos that look the same "
                       "way, it recognizes {}",
                       comparison.num_expected, comparison.num_localized),
           kCorrect);
  }
}

void RequireOneMotion(const MapComparison& comparison, const AgreementOptions& options,
                      const std::string& newcomer) {
  const int num_recognized = comparison.num_recognized();
  const bool is_placed =
      IsAnchored(comparison.anchoring) && IsJudged(comparison) && !IsFromBehind(comparison);
  if (IsKnown(comparison) && num_recognized >= kLeastPhotosToJudge && !is_placed &&
      comparison.fit.num_agreeing < options.min_agreeing_share * num_recognized) {
    Refuse(newcomer,
           fmt::format("the map recognizes {} of {} photos, but only {} of them in places "
                       "that one motion of the session explains{}",
                       num_recognized, comparison.num_asked(), comparison.fit.num_agreeing,
                       MirrorNote(comparison)),
           IsFromBehind(comparison) ? kMirrored : kCorrect);
  }
}

// Two parts of a session that the map sees in two places were put together wrongly. The larger part
// would take the other with it.
void RequireOneGroup(const MapComparison& comparison, const std::string& newcomer) {
  constexpr int kLeastPlaces = 5;
  const FrameSet& winner = comparison.anchoring.winner;
  const FrameSet& rival = comparison.anchoring.rival;
  const bool is_as_large = 2 * rival.num_places >= winner.num_places;
  // The other part may be small, but where it is, the map contradicts it.
  const bool is_where_sought = comparison.num_found_by_rival >= kLeastPlaces &&
                               2 * comparison.num_found_by_rival > comparison.num_sought;
  if (rival.num_places >= kLeastPlaces && (is_as_large || is_where_sought)) {
    Refuse(newcomer,
           fmt::format("the map sees {} of its photos, in {} places, where they agree with each "
                       "other, but {} others, in {} places, agree on another motion",
                       winner.num_frames, winner.num_places, rival.num_frames, rival.num_places),
           "Its parts do not fit each other: mend the reconstruction");
  }
}

// Whether the map knows the place where a session stands: it recognizes some photos, or should
// recognize many.
bool IsOnKnownGround(const MapComparison& comparison, const AgreementOptions& options) {
  return (IsKnown(comparison) && comparison.num_recognized() >= kLeastPhotosToJudge) ||
         comparison.num_expected >=
             std::clamp((comparison.anchoring.session.num_frames + 1) / 2, 1, options.min_expected);
}

// Why a session is not anchored, or is and cannot be judged.
std::string WhyNotAnchored(const MapComparison& comparison) {
  const AnchorEvidence& anchoring = comparison.anchoring;
  if (IsAnchored(anchoring)) {
    return fmt::format(
        "{} photos agree that it stands {:.2f} m away, but of {} photos that the map should then "
        "recognize, {} agree (needed: half)",
        comparison.fit.num_agreeing, comparison.fit.moved_m, comparison.num_expected_after,
        comparison.num_agreeing_after);
  }
  return fmt::format(
      "the map recognizes {} of {} photos, of which {} agree with each other, in {} places over "
      "{:.1f} m (needed: {} places, {:.1f} m, a fifth of those recognized); the largest group that "
      "agrees on another place stands in {}{}",
      anchoring.num_answers, comparison.num_asked(), anchoring.winner.num_frames,
      anchoring.winner.num_places, anchoring.winner.extent_m, PlacesNeeded(anchoring),
      ExtentNeededM(anchoring), anchoring.rival.num_places,
      anchoring.rival_is_apart ? ", far from the others" : "");
}

void RequireAnchored(const MapComparison& comparison, const AgreementOptions& options,
                     const std::string& newcomer) {
  const bool may_stand_alone = options.unanchored == Unanchored::kRefuse;
  if ((may_stand_alone && !IsOnKnownGround(comparison, options)) ||
      (IsAnchored(comparison.anchoring) && IsJudged(comparison))) {
    return;
  }
  throw SessionRefused(
      fmt::format("{} is not anchored: {}. It was placed by nothing. Take more photos of what the "
                  "map shows, or keep it apart from what the map knows, where its positions say "
                  "(--apart)",
                  newcomer, WhyNotAnchored(comparison)));
}

double MovedM(const PlacementFit& fit, const MotionLimits& limits) {
  // Receivers know heights half as well as the rest.
  const double raised_share = limits.follow_accuracy ? 0.5 : 1.0;
  const double level_sq_m = std::max(0.0, fit.moved_m * fit.moved_m - fit.raised_m * fit.raised_m);
  return std::sqrt(level_sq_m + std::pow(raised_share * fit.raised_m, 2));
}

std::string WhyAllowed(const MotionLimits& limits, const PositionAccuracies& accuracy) {
  return limits.follow_accuracy
             ? fmt::format(
                   ", since its positions are good to {:.1f} m and those of the map to "
                   "{:.1f} m",
                   accuracy.session_m, accuracy.map_m)
             : "";
}

bool IsSmall(const PlacementFit& fit, const MotionLimits& limits) {
  return MovedM(fit, limits) <= limits.moved_m && fit.turned_rad <= limits.turned_rad &&
         std::abs(fit.scale - 1.0) <= limits.scale_change;
}

constexpr const char* kStateAccuracy =
    "Correct its georegistration, state how inaccurate its positions are (--gps-accuracy, "
    "accuracy_m of --georef), allow more (ingest.agreement.max_moved_m, max_turned_rad and "
    "max_scale_change of --options)";

void RequireSmallMotion(const MapComparison& comparison, const AgreementOptions& options,
                        const PositionAccuracies& accuracy, const std::string& newcomer) {
  const PlacementFit& fit = comparison.fit;
  const MotionLimits limits = LimitsOf(comparison, options, accuracy);
  if (IsSmall(fit, limits)) {
    return;
  }
  Refuse(newcomer,
         fmt::format("the map sees {} of its photos {:.2f} m away, turned by {:.1f} degrees and "
                     "{:.3f} times as large, {:.2f} m of it upward (allowed: {:.1f} m, {:.1f} "
                     "degrees, {:.3f} to {:.3f}{}){}",
                     fit.num_agreeing, fit.moved_m, fit.turned_rad * kDegPerRad, fit.scale,
                     fit.raised_m, limits.moved_m, limits.turned_rad * kDegPerRad,
                     1.0 - limits.scale_change, 1.0 + limits.scale_change,
                     WhyAllowed(limits, accuracy), MirrorNote(comparison)),
         IsFromBehind(comparison) ? kMirrored : kStateAccuracy);
}

}  // namespace

PlacementOptions PlacementOf(const IngestOptions& options) {
  return {.min_observations = options.selection.min_observations,
          .max_sigma_m = options.max_sigma_m,
          .max_reprojection_error_px = options.max_reprojection_error_px};
}

PositionAccuracies AccuracyOf(const MapComparison& comparison, double stated_m,
                              double median_residual_m, const std::vector<SessionRecord>& map) {
  const std::vector<SessionId>& known = comparison.known_sessions;
  PositionAccuracies accuracy;
  // Without a statement, nobody says how the session was placed.
  accuracy.session_m = stated_m > 0.0 ? std::max(stated_m, median_residual_m) : 0.0;
  for (const SessionRecord& session : map) {
    if (known.empty() || std::binary_search(known.begin(), known.end(), session.id)) {
      accuracy.map_m = std::max(accuracy.map_m, session.georef_median_residual_m);
    }
  }
  return accuracy;
}

MotionLimits LimitsOf(const MapComparison& comparison, const AgreementOptions& options,
                      const PositionAccuracies& accuracy) {
  constexpr double kMaxSigmas = 3.4;
  constexpr double kMaxTurnedRad = 0.5;  // No receiver turns a street by more than this.
  MotionLimits limits = {options.max_moved_m, options.max_turned_rad, options.max_scale_change};
  if (!IsSure(comparison) || IsFromBehind(comparison) || !(accuracy.session_m > 0.0)) {
    return limits;
  }
  constexpr double kSigmas = kMaxSigmas / kRadius68PerSigma2d;
  const double off_m = kSigmas * std::hypot(accuracy.session_m, accuracy.map_m);
  const double spread_m = std::max(1.0, comparison.spread_m);
  const double map_spread_m =
      comparison.map_spread_m > 0.0 ? std::max(1.0, comparison.map_spread_m) : spread_m;
  const double turned_rad =
      std::min(kMaxTurnedRad,
               kSigmas * std::hypot(accuracy.session_m / spread_m, accuracy.map_m / map_spread_m));
  limits.follow_accuracy = off_m > limits.moved_m;
  limits.moved_m = std::max(limits.moved_m, off_m);
  limits.turned_rad = std::max(limits.turned_rad, turned_rad);
  limits.scale_change = std::max(limits.scale_change, turned_rad);
  return limits;
}

void RequireAgreement(const MapComparison& comparison, const AgreementOptions& options,
                      const PositionAccuracies& accuracy, const std::string& newcomer) {
  RequireRecognized(comparison, options, newcomer);
  RequireOneMotion(comparison, options, newcomer);
  if (options.unanchored != Unanchored::kAccept) {
    RequireAnchored(comparison, options, newcomer);
  }
  RequireOneGroup(comparison, newcomer);
  if (IsJudged(comparison)) {
    RequireSmallMotion(comparison, options, accuracy, newcomer);
  }
}

void RequireAnswers(const KeyframeAnswers& answers, const GateOptions& options,
                    const std::string& newcomer) {
  constexpr int kFew = 2;  // As many answers may get lost by chance.
  if (answers.num_lost > kFew &&
      answers.num_lost > options.max_lost_share * static_cast<double>(answers.num_asked)) {
    throw SessionRefused(
        fmt::format("{} was not published: with it, the map no longer localizes {} of {} of its "
                    "own keyframes near by (allowed: {:.0f} %), so it probably stands in the "
                    "wrong place. Correct its georegistration, or publish it all the same "
                    "(--force)",
                    newcomer, answers.num_lost, answers.num_asked, 100.0 * options.max_lost_share));
  }
}

PlacedSession SettleSession(PlacedSession session, const Reconstruction& reconstruction,
                            MapComparison* comparison) {
  if (!IsJudged(*comparison)) {
    return session;
  }
  const Sim3d& map_from_session = comparison->fit.map_from_session;
  for (Rigid3d& cam_from_ecef : session.cam_from_ecef) {
    cam_from_ecef = CamFromTarget(cam_from_ecef, map_from_session);
  }
  for (PlacedLandmark& landmark : session.landmarks) {
    landmark.x_in_ecef = map_from_session * landmark.x_in_ecef;
  }
  comparison->largest_bend_m = BendSession(comparison->bending, &session);
  AssignTiles(reconstruction, &session);
  return session;
}

}  // namespace cairn
