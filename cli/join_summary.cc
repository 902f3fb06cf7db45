#include "cli/join_summary.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/angles.h"

namespace cairn {

namespace {

void PrintAnchoring(const MapComparison& comparison) {
  const AnchorEvidence& anchoring = comparison.anchoring;
  if (anchoring.num_answers == 0) {
    return;
  }
  fmt::print(
      "anchored         {}: {} of {} answers agree, in {} places over {:.1f} m (needed: {} places, "
      "{:.1f} m); the largest other group stands in {}\n",
      IsAnchored(anchoring) ? "yes" : "no", anchoring.winner.num_frames, anchoring.num_answers,
      anchoring.winner.num_places, anchoring.winner.extent_m, PlacesNeeded(anchoring),
      ExtentNeededM(anchoring), anchoring.rival.num_places);
  if (!comparison.bending.is_none()) {
    const DriftField& shift = comparison.bending.shift();
    fmt::print("bending          {:.3f} m at most; a drift of {:.2f} m over about {:.0f} m\n",
               comparison.largest_bend_m, shift.amplitude(), shift.wave_m());
  }
}

}  // namespace

void PrintAdjustment(const JointAdjustment& adjustment) {
  if (adjustment.num_shared > 0) {
    fmt::print(
        "adjustment       {} landmarks shared with the map, which stay; {} observations, {:.2f} px "
        "rms; "
        "cameras moved by {:.3f} m at most\n",
        adjustment.num_shared, adjustment.num_observations, adjustment.rms_px,
        adjustment.largest_move_m);
  }
}

void PrintComparison(const MapComparison& comparison, const char* queries) {
  if (comparison.num_asked() == 0 && !comparison.nearest_tile_m) {
    return;
  }
  fmt::print("comparison       ");
  if (comparison.nearest_tile_m) {
    fmt::print("the nearest tile of the map is about {:.0f} m away; ", *comparison.nearest_tile_m);
  }
  if (comparison.num_asked() == 0) {
    fmt::print("no tile is within 2 km, so the {} were not searched in the map\n", queries);
    return;
  }
  fmt::print("the map recognizes {} of {} {}", comparison.num_localized, comparison.num_expected,
             queries);
  if (comparison.num_sought > 0) {
    fmt::print(" that stand near its own, and {} of {} others", comparison.num_found,
               comparison.num_sought);
  }
  if (comparison.num_recognized() > 0) {
    fmt::print(
        "; {} agree on a move of {:.2f} m and {:.2f} degrees and {:.3f} times the size, residual "
        "{:.3f} m median",
        comparison.fit.num_agreeing, comparison.fit.moved_m, comparison.fit.turned_rad * kDegPerRad,
        comparison.fit.scale, comparison.fit.median_residual_m);
  }
  fmt::print("\n");
  PrintAnchoring(comparison);
  if (!IsJudged(comparison)) {
    fmt::print(
        "                 too few {} agree to judge whether the placement fits the map (at least "
        "{} must); it was taken as it is, and nothing of the map fades or gives way\n",
        queries, kLeastPhotosToJudge);
  }
}

void PrintAnswers(const KeyframeAnswers& answers) {
  if (answers.num_asked > 0) {
    fmt::print("answers          of {} keyframes of the map near by, {} lost theirs\n",
               answers.num_asked, answers.num_lost);
  }
}

void PrintChanges(const TileChanges& changes) {
  fmt::print(
      "                 {} merged, {} new, {} not needed, {} faded, {} evicted (one count for each "
      "tile)\n",
      changes.num_merged, changes.num_new, changes.num_not_needed, changes.num_faded,
      changes.num_evicted);
  fmt::print("keyframes        {} replaced\n", changes.num_keyframes_replaced);
}

nlohmann::ordered_json ComparisonJson(const MapComparison& comparison) {
  nlohmann::ordered_json json = {{"photosExpected", comparison.num_expected},
                                 {"photosRecognized", comparison.num_localized},
                                 {"photosSought", comparison.num_sought},
                                 {"photosFound", comparison.num_found},
                                 {"photosAgreeing", comparison.fit.num_agreeing},
                                 {"judged", IsJudged(comparison)},
                                 {"movedM", comparison.fit.moved_m},
                                 {"raisedM", comparison.fit.raised_m},
                                 {"turnedDeg", comparison.fit.turned_rad * kDegPerRad},
                                 {"scale", comparison.fit.scale},
                                 {"medianResidualM", comparison.fit.median_residual_m}};
  if (comparison.nearest_tile_m) {  // Plans do not store it.
    json["nearestTileM"] = *comparison.nearest_tile_m;
  }
  if (comparison.anchoring.num_answers > 0) {  // Nor this.
    json["anchored"] = IsAnchored(comparison.anchoring);
    json["anchoredPlaces"] = comparison.anchoring.winner.num_places;
    json["rivalPlaces"] = comparison.anchoring.rival.num_places;
    json["largestBendM"] = comparison.largest_bend_m;
  }
  return json;
}

nlohmann::ordered_json AdjustmentJson(const JointAdjustment& adjustment) {
  return {{"sharedLandmarks", adjustment.num_shared},
          {"sights", adjustment.num_observations},
          {"rmsPx", adjustment.rms_px},
          {"largestMoveM", adjustment.largest_move_m}};
}

nlohmann::ordered_json AnswersJson(const KeyframeAnswers& answers) {
  return {{"asked", answers.num_asked}, {"lost", answers.num_lost}};
}

nlohmann::ordered_json ChangesJson(const TileChanges& changes) {
  return {{"merged", changes.num_merged},
          {"new", changes.num_new},
          {"notNeeded", changes.num_not_needed},
          {"faded", changes.num_faded},
          {"evicted", changes.num_evicted},
          {"keyframesReplaced", changes.num_keyframes_replaced},
          {"bytesBefore", changes.num_bytes_before},
          {"bytesAfter", changes.num_bytes_after}};
}

}  // namespace cairn
