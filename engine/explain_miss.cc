#include "engine/explain_miss.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/angles.h"
#include "core/error.h"
#include "engine/nearest_tile.h"

namespace cairn {
namespace {

// A slip of a coordinate puts a position far away, and its correction at the map.
constexpr double kFarM = 50e3;
constexpr double kAtMapM = 1e3;

// Two digits are enough for a person: "350 m", "4.2 km", "5,400 km".
std::string DistanceText(double distance_m) {
  const double digits = std::pow(10.0, std::floor(std::log10(std::max(distance_m, 1.0))) - 1.0);
  const double rounded_m = digits >= 1.0 ? std::round(distance_m / digits) * digits : distance_m;
  if (rounded_m < 1e3) {
    return fmt::format("{:.0f} m", rounded_m);
  }
  if (rounded_m < 10e3) {
    return fmt::format("{:.1f} km", 1e-3 * rounded_m);
  }
  const auto km = static_cast<int>(std::lround(1e-3 * rounded_m));
  return km < 1000 ? fmt::format("{} km", km) : fmt::format("{},{:03} km", km / 1000, km % 1000);
}

// The slip that would explain a position far from the map; null if there is none.
const char* CoordinateSlip(const Geodetic& position, const MapSnapshot& map) {
  const auto is_at_map = [&](double lat_rad, double lon_rad) {
    return !map.FindTiles(BoxAround({lat_rad, lon_rad, 0.0}, kAtMapM)).empty();
  };
  if (position.lat_rad == 0.0 && position.lon_rad == 0.0) {
    return "0, 0 is what a receiver without a fix reports; leave the position out instead";
  }
  if (std::abs(position.lon_rad) <= 0.5 * kPi && is_at_map(position.lon_rad, position.lat_rad)) {
    return "are latitude and longitude swapped?";
  }
  if (is_at_map(position.lat_rad, -position.lon_rad)) {
    return "is the sign of the longitude right? West is negative";
  }
  if (is_at_map(-position.lat_rad, position.lon_rad)) {
    return "is the sign of the latitude right? South is negative";
  }
  return nullptr;
}

// `slip` may be null.
const char* NoCoverageHint(const PositionPrior& prior, double distance_m, const char* slip,
                           double max_radius_m) {
  if (slip != nullptr) {
    return slip;
  }
  if (prior.source == PriorSource::kPhoto) {
    return "is the position in the photo's EXIF right? Give another one, or ignore the EXIF to "
           "search the whole map";
  }
  return distance_m < max_radius_m ? "a larger accuracy widens the search"
                                   : "leave the position out to search the whole map";
}

std::string ExplainNoCoverage(const PositionPrior& prior, double max_radius_m,
                              const MapSnapshot& map) {
  const std::optional<double> distance_m = NearestTileM(map, prior.position);
  if (!distance_m) {
    return "the map has no tiles yet; ingest a session first";
  }
  const char* slip = *distance_m > kFarM ? CoordinateSlip(prior.position, map) : nullptr;
  return fmt::format("the nearest tile is {} away; {}", DistanceText(*distance_m),
                     NoCoverageHint(prior, *distance_m, slip, max_radius_m));
}

std::string NoCoverage(const LocalizeQuery& query, const LocalizerOptions& options,
                       const MapSnapshot* map) {
  if (!query.prior) {
    return "the map has no tiles yet; ingest a session first";
  }
  if (map != nullptr) {
    try {
      return ExplainNoCoverage(*query.prior, options.prior.max_radius_m, *map);
    } catch (const Error&) {  // The map went silent, or its version was pruned.
    }
  }
  return "no tile is near the position; is the position right?";
}

std::string Tiles(int64_t count) { return fmt::format("{} tile{}", count, count == 1 ? "" : "s"); }

// What most probably kept a pose from being found.
std::string SearchHint(const LocalizeQuery& query, const StageCounters& counters) {
  if (counters.num_tiles_searched < counters.num_tiles_found) {
    return fmt::format("a position lets the server search in the right ones of the {} tiles",
                       counters.num_tiles_found);
  }
  if (query.prior && query.prior->source == PriorSource::kPhoto) {
    return "does the photo show a mapped place, and is the position in its EXIF right?";
  }
  if (query.focal && query.focal->with_distortion) {
    return "does the photo show a mapped place? A known focal length helps, too";
  }
  return query.prior ? "does the photo show a mapped place, and is the position right?"
                     : "does the photo show a mapped place?";
}

std::string Timeout(const StageCounters& counters) {
  if (counters.tiles_cut_short) {
    return "the time ended while tiles were loaded; they will be there for the next query, so ask "
           "again or allow more time";
  }
  if (counters.num_tiles_searched == 0) {
    return "the time ended before the search began, because the server is busy or the photo is "
           "large; allow more time";
  }
  return "the time ended before the search did; allow more time";
}

}  // namespace

std::string ExplainMiss(const LocalizeQuery& query, const LocalizeResult& result,
                        const LocalizerOptions& options, const MapSnapshot* map) {
  const StageCounters& counters = result.counters;
  switch (result.reason) {
    case NotLocalizedReason::kNone:
      return "";
    case NotLocalizedReason::kNoCoverage:
      return NoCoverage(query, options, map);
    case NotLocalizedReason::kTooFewFeatures:
      return fmt::format(
          "the photo shows {} features, and a pose needs {}; is it dark, blurred or of a bare "
          "wall?",
          counters.num_keypoints, options.pose.min_inliers);
    case NotLocalizedReason::kTooFewMatches:
      return fmt::format("{} searched know {} of the photo's {} features; {}",
                         Tiles(counters.num_tiles_searched), counters.num_matched_keypoints,
                         counters.num_keypoints, SearchHint(query, counters));
    case NotLocalizedReason::kTooFewInliers:
      return fmt::format("no pose explains enough of the {} matches in {} to be sure; {}",
                         counters.num_matches, Tiles(counters.num_tiles_searched),
                         SearchHint(query, counters));
    case NotLocalizedReason::kAmbiguous:
      return "two places explain the photo about equally well; a more accurate position or the "
             "direction of gravity decides between them";
    case NotLocalizedReason::kPriorMismatch:
      return "the best pose is far from the position and has too little evidence for that; is the "
             "position right? A larger accuracy allows more";
    case NotLocalizedReason::kTimeout:
      return Timeout(counters);
  }
  return "";
}

}  // namespace cairn
