// Moves the parts of a session to where a map sees them.
#ifndef CAIRN_INGEST_FIT_PARTS_H_
#define CAIRN_INGEST_FIT_PARTS_H_

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "ingest/ingest_options.h"
#include "ingest/place/compare_with_map.h"
#include "storage/map/map_store.h"

namespace cairn {

// Images of a reconstruction that share no landmark with its other images. Its positions alone
// placed the part, meters beside the others, or the map did (PlaceByMap).
struct SessionPart {
  std::vector<int> images;   // Of the reconstruction that FitParts was given; ascending.
  bool needs_map = false;    // Its positions do not place it.
  std::string problem = {};  // Why the part is no longer in the reconstruction; empty if it is.
  bool is_anchored = false;  // By the map, which does not contradict it.
  double moved_m = 0.0;      // How far it moved, at the middle of its cameras.
  MapComparison comparison = {};
};

// An ingest moves a session as one piece, which is wrong for several parts. This moves each of them
// by itself. `part_of_image` has the number of each image's part, `placed_by_map` the numbers of
// those that their positions do not place.
//
// A part that the map anchors and does not contradict (RequireAgreement, Unanchored::kRefuseAlways)
// moves by the motion of its comparison. Other parts leave the reconstruction, also those without a
// landmark that is good enough (PlaceSession).
//
// If the map anchors no part, nothing moves. Parts that the map placed leave. Of the others, all
// stay if the map is too far away to be asked about any of them; else only the one with the most
// images stays. So it is, too, if the map anchors only parts that it placed, and these have fewer
// images than the others.
//
// A session of the map with the name of `options` has no say. Returns the parts by number. Throws
// what the engine throws on a damaged map.
std::map<int, SessionPart> FitParts(const MapSnapshot& map, const std::vector<int>& part_of_image,
                                    const std::set<int>& placed_by_map,
                                    const Sim3d& ecef_from_world, const IngestOptions& options,
                                    Reconstruction* reconstruction);

}  // namespace cairn

#endif  // CAIRN_INGEST_FIT_PARTS_H_
