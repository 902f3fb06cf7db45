// How a session becomes part of a map.
#ifndef CAIRN_INGEST_INGEST_OPTIONS_H_
#define CAIRN_INGEST_INGEST_OPTIONS_H_

#include <chrono>
#include <string>

#include "ingest/codebook/train_codebook.h"
#include "ingest/tiles/appearance.h"
#include "ingest/tiles/landmark_history.h"
#include "ingest/tiles/landmark_selection.h"
#include "ingest/tiles/link_landmarks.h"
#include "ingest/tiles/merge_tiles.h"
#include "ingest/tiles/viewpoints.h"

namespace cairn {

enum class SessionJoining {
  kJoin,   // Landmarks that the map knows are updated; a session that contradicts the map is
           // refused.
  kApart,  // The session's landmarks stand beside those of the map; nothing is compared.
};

// What becomes of a session that is not anchored in the map (IsAnchored,
// ingest/anchor/consistent_frames.h).
enum class Unanchored {
  kAccept,        // It is taken as it is if nothing contradicts it.
  kRefuse,        // It is refused if the map knows the place where it stands.
  kRefuseAlways,  // It is refused, on new ground, too.
};

// How closely a session that is anchored in the map follows it.
enum class SessionFitting {
  kBend,    // By a smooth drift.
  kAdjust,  // Then by a bundle adjustment in which the landmarks of the map stay.
};

// How far a session may contradict the map. See MapComparison and LimitsOf
// (ingest/session_placement.h).
struct AgreementOptions {
  // Limits for accurate positions. They grow with position_accuracy_m.
  double max_moved_m = 3.0;
  double max_turned_rad = 0.05;  // 3 degrees.
  double max_scale_change = 0.05;
  // Radius that contains 68 % of the positions that placed the session, as stated. 0: unknown.
  double position_accuracy_m = 0.0;
  double min_agreeing_share = 0.5;  // Of the photos that the map recognizes.
  // Share of the photos that the map should recognize. Not checked for fewer than min_expected such
  // photos.
  double min_recognized_share = 0.1;
  int min_expected = 10;
  Unanchored unanchored = Unanchored::kAccept;

  void Validate() const;
};

// What an update may take from the map. See AskKeyframes (ingest/place/ask_keyframes.h).
struct GateOptions {
  // Share of the map's keyframes, of those that are asked for, that may lose their answer. Normal
  // updates lose none or few, since places change; a misplaced session takes most.
  double max_lost_share = 0.2;

  void Validate() const;
};

// Upkeep of a place that several sessions have seen.
struct UpkeepOptions {
  LinkOptions linking;
  MergeOptions merging;
  ViewpointOptions viewpoints;
  PersistenceOptions persistence;
  // A session adds landmarks of its own until each of its photos sees this many, known and new
  // together. A photo on new ground adds all of its landmarks; see AdmitLandmarks.
  int enough_landmarks = 250;
  double least_existence = 0.1;  // Landmarks that exist with a smaller probability go.

  void Validate() const;
};

// All options that change the content of a tile. A plan stores them (docs/formats/plan_v1.md), so a
// new member needs a line in ingest/ingest_option_visit.h, which does not compile without its name.
struct TileOptions {
  SessionJoining joining = SessionJoining::kJoin;
  LandmarkSelectionOptions selection;
  AppearanceOptions appearance;
  UpkeepOptions upkeep;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

struct IngestOptions : TileOptions {
  std::string session_name;  // Unique in the map; ingesting a name again replaces the session.
  std::string source;        // For people.
  std::string recorded_at;   // When the photos were taken, see SessionRecord; empty: `now`.
  std::string now;           // The time of the ingest, in the same form; empty: that of the clock.
  CodebookOptions codebook;  // Used only by the first session of a map.
  AgreementOptions agreement;
  GateOptions gate;
  SessionFitting fitting = SessionFitting::kBend;
  // Landmarks with a larger standard deviation of the position are dropped, meters.
  double max_sigma_m = 2.0;
  // Landmarks with a larger median reprojection error are dropped, pixels.
  double max_reprojection_error_px = 4.0;
  double georef_median_residual_m = 0.0;  // Recorded with the session.
  // How far the placement of the session is from its true place and direction on Earth: 68 % radii.
  // A session without a place (0) has no accuracy.
  double earth_accuracy_m = 0.0;
  double earth_accuracy_rad = 0.0;
  // Threads that ask the map and build tiles. The result does not depend on it.
  int num_threads = 1;
  // How long the ingest waits while another update of the map runs.
  std::chrono::milliseconds patience{0};

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_INGEST_OPTIONS_H_
