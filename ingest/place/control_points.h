// Places a reconstruction on Earth by surveyed points that its photos show.
#ifndef CAIRN_INGEST_PLACE_CONTROL_POINTS_H_
#define CAIRN_INGEST_PLACE_CONTROL_POINTS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/geodesy.h"
#include "core/geoid.h"
#include "ingest/place/georegister.h"

namespace cairn {

// Where a photo shows a point.
struct ControlObservation {
  std::string image_name;
  Eigen::Vector2d pixel;
};

struct ControlPoint {
  std::string name;
  Geodetic position;
  double accuracy_m = 0.1;  // 68 % radius: of the survey, and of pixels that people click.
  std::vector<ControlObservation> observations;
  std::optional<HeightReference> height_reference = {};  // If the table states it.
};

// Reads a CSV (core/csv.h) with a header and the columns point, lat_deg, lon_deg, h_m, image, x_px,
// y_px and optionally accuracy_m, in any order: a row for each photo that shows a point. Pixels are
// COLMAP's: (0.5, 0.5) is the center of the upper left one. Throws Error(kBadInput), with file,
// line and column, also if rows of one point state different positions, and for a height that no
// place has.
std::vector<ControlPoint> ReadControlPoints(const std::string& path);

// Converts heights to heights above the ellipsoid. They are above `chosen`, else above what the
// point states, else above the ellipsoid already.
void MakeHeightsEllipsoidal(std::optional<HeightReference> chosen,
                            std::vector<ControlPoint>* points);

// Triangulates each point from the photos that show it, and fits the similarity of Georegister to
// the points; the residuals and names of the result are those of the points. Names of photos match
// as those of positions do. Points that fewer than two photos of the reconstruction show, or whose
// rays do not meet (half of the photos miss by more than 20 pixels), do not count and are noted.
// Throws as Georegister, which needs three points that are not on a line.
Georegistration GeoregisterByControl(const Reconstruction& reconstruction,
                                     const std::vector<ControlPoint>& points,
                                     const GeoregisterOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_CONTROL_POINTS_H_
