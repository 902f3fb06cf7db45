#include "ingest/place/control_points.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/match_names.h"
#include "core/printable.h"
#include "core/scene/triangulate.h"
#include "ingest/place/position_checks.h"
#include "ingest/place/position_table.h"

namespace cairn {
namespace {

bool IsSamePlace(const Geodetic& a, const Geodetic& b) {
  return a.lat_rad == b.lat_rad && a.lon_rad == b.lon_rad && a.h_m == b.h_m;
}

// For each name that observations use, the index of the image; -1 if the reconstruction has none.
std::map<std::string, int> ImagesOfObservations(const Reconstruction& reconstruction,
                                                const std::vector<ControlPoint>& points) {
  std::map<std::string, int> image_of_name;
  for (const ControlPoint& point : points) {
    for (const ControlObservation& observation : point.observations) {
      image_of_name.emplace(observation.image_name, -1);
    }
  }
  std::vector<std::string> wanted, known;
  for (const auto& [name, image_idx] : image_of_name) {
    wanted.push_back(name);
  }
  for (const ReconImage& image : reconstruction.images) {
    known.push_back(image.name);
  }
  const NameMatches matches = MatchNames(wanted, known);
  bool has_match = false;
  for (size_t i = 0; i < wanted.size(); ++i) {
    image_of_name[wanted[i]] = matches.known_of_wanted[i];
    has_match = has_match || matches.known_of_wanted[i] >= 0;
  }
  if (!has_match) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("none of the photos that show control points is in the model: the "
                            "photos are {}, the images of the model are {}",
                            ExampleNames(wanted), ExampleNames(known)));
  }
  return image_of_name;
}

std::vector<PointObservation> ObservationsOfPoint(const Reconstruction& reconstruction,
                                                  const ControlPoint& point,
                                                  const std::map<std::string, int>& image_of_name) {
  std::vector<PointObservation> observations;
  for (const ControlObservation& observation : point.observations) {
    const int image_idx = image_of_name.at(observation.image_name);
    if (image_idx >= 0) {
      const ReconImage& image = reconstruction.images[static_cast<size_t>(image_idx)];
      observations.push_back({&reconstruction.cameras[static_cast<size_t>(image.camera_idx)],
                              image.cam_from_world, observation.pixel, 1.0});
    }
  }
  return observations;
}

// Where the rays of the observations meet; nothing if they pass each other.
std::optional<Eigen::Vector3d> MeetingPoint(const std::vector<PointObservation>& observations) {
  // Clicks err by some pixels, the pixel of another point by more.
  constexpr double kMaxErrorPx = 20.0;
  const std::optional<Eigen::Vector3d> x_in_world = TriangulatePoint(observations);
  const std::optional<PointUncertainty> uncertainty =
      x_in_world ? EstimateUncertainty(observations, *x_in_world) : std::nullopt;
  return uncertainty && uncertainty->median_error_px <= kMaxErrorPx ? x_in_world : std::nullopt;
}

}  // namespace

std::vector<ControlPoint> ReadControlPoints(const std::string& path) {
  const ControlPoint defaults;
  PositionTable table(path, {"point", "lat_deg", "lon_deg", "h_m", "image", "x_px", "y_px"});
  std::vector<ControlPoint> points;
  std::map<std::string, size_t> point_of_name;
  while (table.NextRow()) {
    const std::string& name = table.Text("point");
    if (!table.Has("h_m")) {
      table.Throw(fmt::format("column h_m: the point {} has no height", Excerpt(name)));
    }
    const Geodetic position = table.Position(name);
    if (position.h_m < kLowestPlaceM || position.h_m > kHighestPlaceM) {
      table.Throw(
          fmt::format("column h_m: the point {} cannot be at {} m", Excerpt(name), position.h_m));
    }
    const auto [entry, is_new] = point_of_name.emplace(name, points.size());
    if (is_new) {
      points.push_back({.name = name,
                        .position = position,
                        .accuracy_m = table.AccuracyOr(defaults.accuracy_m),
                        .observations = {},
                        .height_reference = table.height_reference()});
    }
    ControlPoint& point = points[entry->second];
    if (!IsSamePlace(point.position, position)) {
      table.Throw(
          fmt::format("the point {} has another position in an earlier line", Excerpt(name)));
    }
    point.observations.push_back(
        {.image_name = table.Text("image"), .pixel = {table.Number("x_px"), table.Number("y_px")}});
  }
  if (points.empty()) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: there is no point below the header", path));
  }
  return points;
}

void MakeHeightsEllipsoidal(std::optional<HeightReference> chosen,
                            std::vector<ControlPoint>* points) {
  for (ControlPoint& point : *points) {
    const HeightReference stated = point.height_reference.value_or(HeightReference::kEllipsoid);
    point.position = WithEllipsoidalHeight(point.position, chosen.value_or(stated));
    point.height_reference = HeightReference::kEllipsoid;
  }
}

Georegistration GeoregisterByControl(const Reconstruction& reconstruction,
                                     const std::vector<ControlPoint>& points,
                                     const GeoregisterOptions& options) {
  const std::map<std::string, int> image_of_name = ImagesOfObservations(reconstruction, points);
  // Georegister fits cameras to positions, so each point becomes a camera that stands there.
  Reconstruction cameras_at_points;
  cameras_at_points.cameras.emplace_back();
  std::vector<CameraPosition> positions;
  std::vector<std::string> notes;
  for (const ControlPoint& point : points) {
    const std::vector<PointObservation> observations =
        ObservationsOfPoint(reconstruction, point, image_of_name);
    const std::optional<Eigen::Vector3d> x_in_world = MeetingPoint(observations);
    if (!x_in_world) {
      notes.push_back(
          fmt::format("the control point {} does not count: {}", Excerpt(point.name),
                      observations.size() < 2
                          ? fmt::format("{} photos of the model show it, and two are needed",
                                        observations.size())
                          : "the rays of its photos do not meet"));
      continue;
    }
    ReconImage& image = cameras_at_points.images.emplace_back();
    image.name = point.name;
    image.cam_from_world = Rigid3d(Eigen::Quaterniond::Identity(), -*x_in_world);
    positions.push_back({point.name, point.position, point.accuracy_m});
  }
  GeoregisterOptions by_points = options;
  by_points.up = UpSource::kPositions;  // The points themselves; nothing is known of cameras.
  by_points.upright_sigma_rad = 0.0;
  try {
    Georegistration result = Georegister(cameras_at_points, positions, by_points);
    result.up.source = "the control points";
    result.notes = std::move(notes);
    return result;
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("control points: {}{}{}", error.what(),
                                          notes.empty() ? "" : "; ", fmt::join(notes, "; ")));
  }
}

}  // namespace cairn
