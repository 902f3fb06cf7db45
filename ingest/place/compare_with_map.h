// Compares the placement of a session with the map: the engine localizes photos of the session.
#ifndef CAIRN_INGEST_PLACE_COMPARE_WITH_MAP_H_
#define CAIRN_INGEST_PLACE_COMPARE_WITH_MAP_H_

#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "ingest/anchor/bending.h"
#include "ingest/anchor/consistent_frames.h"
#include "ingest/place/fit_placement.h"
#include "ingest/place/known_tiles.h"
#include "ingest/tiles/placed_session.h"
#include "storage/ids.h"

namespace cairn {

// The result of the comparison. An *expected* photo stands near a photo of the map that looks the
// same way (ingest/tiles/near_view.h), so the map should recognize it. Another photo is *sought*:
// within 100 m of where it stands if a tile is as near, and else in all tiles around the session.
// The map recognizes it if it, or the session, is misplaced.
struct MapComparison {
  int num_expected = 0;        // Expected photos that were asked for.
  int num_localized = 0;       // Of these, the photos that the map recognized.
  int num_sought = 0;          // Sought photos that were asked for.
  int num_found = 0;           // Of these, the photos that the map recognized for sure.
  int num_found_by_rival = 0;  // Of the photos found, those of anchoring.rival.
  // From the nearest photo to the nearest tile if no photo stands within 100 m of one; empty, too,
  // if the map has no tiles.
  std::optional<double> nearest_tile_m;
  // Recognized photos that see what they recognize from the side opposite to that of the mapping
  // photos, as a mirrored session or a session in a mirrored map does.
  int num_from_behind = 0;
  int num_agreeing_from_behind = 0;  // Of the photos that agree.
  // Of the recognized photos; meaningful if there are any. If the session is anchored, the photos
  // that agree are those that are consistent with each other (FindConsistentFrames), the motion is
  // theirs, and the residuals are those that stay after `bending`.
  PlacementFit fit;
  AnchorEvidence anchoring;
  // How the session bends after the motion; none unless it is anchored in ten places.
  Bending bending;
  double largest_bend_m = 0.0;  // Of all photos of the session. Filled in once it has settled.
  // After the motion of the fit: the asked photos that the map should recognize, and those of them
  // that agree on the motion.
  int num_expected_after = 0;
  int num_agreeing_after = 0;
  // Root of the sum of squared distances of the session's cameras from their middle, meters: an
  // error of the positions turns the session by this error over the spread.
  double spread_m = 0.0;
  // The same of the keyframes of the earliest of `known_sessions`, which tells the size of the map
  // there: later ones followed it. 0 without such a session.
  double map_spread_m = 0.0;
  std::vector<SessionId> known_sessions;  // With keyframes in the tiles of the session; ascending.

  int num_asked() const { return num_expected + num_sought; }
  int num_recognized() const { return num_localized + num_found; }
};

// Fewer photos neither move a session nor contradict it.
inline constexpr int kLeastPhotosToJudge = 3;

// Returns whether enough photos agree on a motion to follow it. A motion by more than 8 m, of few
// photos, also has to explain half of the photos that the map should recognize after it: facades
// that repeat pretend motions that only some photos support. If not judged, and not refused, the
// map cannot tell whether the session stands in the right place.
bool IsJudged(const MapComparison& comparison);

// Whether the map knows the place where the session stands: it recognizes some of the photos that
// it should, or half of all that were asked for. A few sure answers to photos of new ground
// contradict nothing.
bool IsKnown(const MapComparison& comparison);

// Photos are sought within this distance of where they stand, or anywhere.
inline constexpr double kReachM = 100.0;

// The photos that CompareWithMap may ask for.
struct PhotosToAsk {
  std::vector<int> expected;  // At most 60, evenly over the expected photos.
  // At most 24 of each, evenly over the other photos within 100 m of a tile of the map and beyond,
  // in the order in which they are asked for.
  std::vector<int> sought_near, sought_anywhere;
};
PhotosToAsk ChoosePhotos(const PlacedSession& session, const KnownTiles& map);

// What CompareWithMap has to know of the session beside its content.
struct ComparisonOptions {
  // Radius that contains 68 % of the positions that placed the session; 0: unknown. Positions that
  // err leave the size of a short walk uncertain.
  double position_accuracy_m = 0.0;
  bool may_bend = true;
  int num_threads = 1;  // The result does not depend on it.
};

// Localizes photos of the session by the features of the reconstruction: raw, or in the projected
// space of the map's codebook. Asks for the expected photos first. Then for the sought photos, near
// ones and those beyond: a few first, the others only if the map recognizes one, and either fewer
// than half of the expected photos agree on one motion and anchor the session, or most of those
// found do not agree with it. Photos beyond are searched in the 400 tiles within 2 km that are
// nearest to one of them, so a session that is misplaced by more is not found. Throws what the
// engine throws on a damaged map.
MapComparison CompareWithMap(const Reconstruction& reconstruction, const PlacedSession& session,
                             const KnownTiles& map, const ComparisonOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_COMPARE_WITH_MAP_H_
