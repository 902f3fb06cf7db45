// Finds camera positions that cannot be positions, by what they look like.
#ifndef CAIRN_INGEST_PLACE_POSITION_CHECKS_H_
#define CAIRN_INGEST_PLACE_POSITION_CHECKS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ingest/place/georegister.h"

namespace cairn {

// What was found, for the summary.
struct PositionFindings {
  int num_at_null_island = 0;   // At 0, 0: left out.
  int num_without_height = 0;   // These say nothing about heights.
  double rounded_to_deg = 0.0;  // All coordinates are multiples of this; 0: they are not rounded.
};

// Sentences about positions at 0, 0 and without a height.
std::vector<std::string> NotesOnPositions(const PositionFindings& findings);

// Heights outside of these are placeholders, such as -9999: no street lies there.
inline constexpr double kLowestPlaceM = -500.0, kHighestPlaceM = 10'000.0;

// Looks at positions as they were read, before their heights are converted. Removes those at 0, 0.
// A height of exactly 0 is taken as missing if the other heights are far from it, and one that no
// place has (kLowestPlaceM, kHighestPlaceM) always. Positions without
// a height get `default_height_m`, or else the median of the others and has_height false. Throws
// Error(kBadInput), with what to do, if all positions are the same, if all heights are missing and
// there is no default, or if the coordinates are rounded so coarsely that their accuracy cannot be
// the stated one.
PositionFindings CheckPositions(const std::optional<double>& default_height_m,
                                std::vector<CameraPosition>* positions);

// Compares the positions of a table with those in the EXIF of the same photos. Throws
// Error(kBadInput), naming the table, if the median distance on the ground is more than a kilometer
// and would be less with latitude and longitude exchanged. Returns a sentence if the distance is
// more than a kilometer either way: the table counts. Fewer than three photos say nothing, nor does
// EXIF at 0, 0.
std::optional<std::string> CompareWithExif(const std::string& table_path,
                                           const std::vector<CameraPosition>& table,
                                           const std::vector<CameraPosition>& exif);

// Throws Error(kBadInput), with what to do, if `has_map_at` says that there is a map about where
// the positions would be with latitude and longitude exchanged, and none about where they are.
void RequireNotExchanged(const std::vector<CameraPosition>& positions,
                         const std::function<bool(const Geodetic& place)>& has_map_at);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_POSITION_CHECKS_H_
