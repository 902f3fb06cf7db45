// The descriptions (core/option_visit.h) of the options of ingest_options.h.
#ifndef CAIRN_INGEST_INGEST_OPTION_VISIT_H_
#define CAIRN_INGEST_INGEST_OPTION_VISIT_H_

#include "core/option_visit.h"
#include "ingest/ingest_options.h"
#include "ingest/tiles/tile_option_visit.h"

namespace cairn {

template <OptionsOf<AgreementOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [max_moved_m, max_turned_rad, max_scale_change, position_accuracy_m, min_agreeing_share,
         min_recognized_share, min_expected, unanchored] = options;
  visitor.Visit("max_moved_m", max_moved_m, AtLeast(0.0),
                "Farthest that a session with accurate positions is moved, meters");
  visitor.Visit("max_turned_rad", max_turned_rad, AtLeast(0.0),
                "Most that a session with accurate positions is turned, radians");
  visitor.Visit("max_scale_change", max_scale_change, AtLeast(0.0),
                "Largest difference of a session's size, as share");
  visitor.Visit("position_accuracy_m", position_accuracy_m, FiniteFrom(0.0),
                "Radius that contains 68 % of the positions that placed the session, meters; the "
                "limits above grow with it. 0: that of --georef or --gps-accuracy");
  visitor.Visit("min_agreeing_share", min_agreeing_share, WithinOf(0.0, 1.0),
                "Smallest share of the recognized photos that one motion of the session explains");
  visitor.Visit("min_recognized_share", min_recognized_share, WithinOf(0.0, 1.0),
                "Smallest share of the photos that the map should recognize and does");
  visitor.Visit(
      "min_expected", min_expected, AtLeast(1),
      "With fewer photos that the map should recognize, min_recognized_share does not count");
  visitor.Visit("unanchored", unanchored, AnyValue(),
                "What becomes of a session that is not anchored in the map: it is taken as it is, "
                "or refused where the map knows the place, as cairn map does, or refused always");
}

template <OptionsOf<GateOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [max_lost_share] = options;
  visitor.Visit("max_lost_share", max_lost_share, WithinOf(0.0, 1.0),
                "Largest share of the map's keyframes, of those that are asked for, that the new "
                "version may no longer localize; 1 (--force): all of them");
}

template <OptionsOf<UpkeepOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [linking, merging, viewpoints, persistence, enough_landmarks, least_existence] = options;
  visitor.Visit("enough_landmarks", enough_landmarks, AtLeast(0),
                "A session adds landmarks until each of its photos sees this many");
  visitor.Visit("least_existence", least_existence, WithinOf(0.0, 1.0),
                "Landmarks that exist with a smaller probability go");
  visitor.Section("linking", linking, "When a landmark of a session is one of the map");
  visitor.Section("merging", merging, "How sessions share a landmark");
  visitor.Section("viewpoints", viewpoints, "When two photos have the same viewpoint");
  visitor.Section("persistence", persistence, "How landmarks fade");
}

template <OptionsOf<TileOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [joining, selection, appearance, upkeep] = options;
  visitor.Visit("joining", joining, AnyValue(), "Whether landmarks of the map are updated");
  visitor.Section("selection", selection, "Which landmarks of a tile are kept");
  visitor.Section("appearance", appearance, "Which descriptors represent a landmark");
  visitor.Section("upkeep", upkeep, "What becomes of a place that the map knows");
}

}  // namespace cairn

#endif  // CAIRN_INGEST_INGEST_OPTION_VISIT_H_
