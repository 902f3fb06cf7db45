// The picture of what became of photos: report.svg and report.png of `cairn map --work`.
#ifndef CAIRN_CLI_MAP_REPORT_H_
#define CAIRN_CLI_MAP_REPORT_H_

#include <vector>

#include "cli/publish_in_turn.h"
#include "eval/pictures/drawing.h"

namespace cairn {

// From top to bottom:
//  - a view from above, north up, with a bar for the scale: of each session the way by the
//    positions (before), the way of the cameras in the order of the photos (after), as the map
//    moved and bent it if the session has joined one, a line from each position to its camera as
//    the positions alone place it, and the positions of photos that were left out;
//  - for each session its figures, the distance of each photo's position from its camera with the
//    median, and the photos that were left out;
//  - the reasons why photos were left out.
Drawing DrawMapReport(const std::vector<MapSessionResult>& sessions);

}  // namespace cairn

#endif  // CAIRN_CLI_MAP_REPORT_H_
