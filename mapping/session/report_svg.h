// A picture of what became of the photos: w/report.svg.
#ifndef CAIRN_MAPPING_SESSION_REPORT_SVG_H_
#define CAIRN_MAPPING_SESSION_REPORT_SVG_H_

#include <string>

#include "mapping/session/map_photos.h"

namespace cairn {

// A view from above, north up, with a bar for the scale: the way by the positions (before), the way
// of the cameras (after) in the order of the photos, a line from each position to its camera, and
// the positions of photos that were left out.
std::string ReportSvg(const MappedPhotos& mapped);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_REPORT_SVG_H_
