#include "ingest/place/position_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "core/geodesy.h"
#include "core/printable.h"
#include "core/statistics.h"

namespace cairn {
namespace {

// Ten meters around 0, 0, in the Gulf of Guinea.
constexpr double kNullIslandDeg = 1e-4;
// Fewer positions may agree by chance.
constexpr size_t kFewestToJudge = 3;
// A height of 0 is taken as missing if the others are farther from 0 than GPS heights err, and than
// three times as far as they differ from each other.
constexpr double kHeightErrorM = 15.0, kHeightSpreads = 3.0;
// Steps of coordinates with this many decimals or fewer are coarser than GPS.
constexpr int kMostRoundedDecimals = 4;
constexpr double kMetersPerDeg = 111'000.0;
// Nearer than this, a table may differ from the EXIF of its photos.
constexpr double kMaxFromExifM = 1000.0;

bool IsAtNullIsland(const CameraPosition& position) {
  return std::abs(position.position.lat_deg()) < kNullIslandDeg &&
         std::abs(position.position.lon_deg()) < kNullIslandDeg;
}

void RequireDifferentPlaces(const std::vector<CameraPosition>& positions) {
  if (positions.size() < kFewestToJudge) {
    return;
  }
  const Geodetic& first = positions[0].position;
  const bool all_same = std::all_of(positions.begin(), positions.end(), [&](const auto& other) {
    return other.position.lat_rad == first.lat_rad && other.position.lon_rad == first.lon_rad;
  });
  if (all_same) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("georegistration: all {} positions are the same, {:.6f}, {:.6f}, so they "
                    "are not where the photos were taken; give the position of each photo",
                    positions.size(), first.lat_deg(), first.lon_deg()));
  }
}

// The coarsest power of ten of which all coordinates are multiples; 0 if there is none.
double RoundingOf(const std::vector<CameraPosition>& positions) {
  double step_deg = 1.0;
  for (int decimals = 0; decimals <= kMostRoundedDecimals; ++decimals, step_deg *= 0.1) {
    const auto is_multiple = [&](double angle_deg) {
      const double steps = angle_deg / step_deg;
      return std::abs(steps - std::round(steps)) < 1e-6;
    };
    if (std::all_of(positions.begin(), positions.end(), [&](const CameraPosition& position) {
          return is_multiple(position.position.lat_deg()) &&
                 is_multiple(position.position.lon_deg());
        })) {
      return step_deg;
    }
  }
  return 0.0;
}

void RequireFineSteps(double rounded_to_deg, const std::vector<CameraPosition>& positions) {
  std::vector<double> accuracies_m;
  for (const CameraPosition& position : positions) {
    accuracies_m.push_back(position.accuracy_m);
  }
  // Standard deviation of rounding, of latitude and longitude together at the equator.
  const double error_m = rounded_to_deg * kMetersPerDeg / std::sqrt(6.0);
  if (error_m <= Median(accuracies_m)) {
    return;
  }
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("georegistration: all positions are rounded to {:g} degrees, which moves them by "
                  "{:.0f} m; the stated accuracy is {:.1f} m. Give positions with six decimals or "
                  "more, or state the accuracy that they have",
                  rounded_to_deg, error_m, Median(accuracies_m)));
}

// What stands for no height, in messages.
std::string WordsForNoHeight() {
  return fmt::format("0 and heights below {:.0f} m or above {:.0f} m stand for none", kLowestPlaceM,
                     kHighestPlaceM);
}

void MarkImpossibleHeights(std::vector<CameraPosition>* positions) {
  for (CameraPosition& position : *positions) {
    const double h_m = position.position.h_m;
    position.has_height = position.has_height && h_m >= kLowestPlaceM && h_m <= kHighestPlaceM;
  }
}

// The positions that have no height: marked so, or 0 far from the others.
void MarkMissingHeights(std::vector<CameraPosition>* positions) {
  MarkImpossibleHeights(positions);
  std::vector<double> heights_m;
  for (const CameraPosition& position : *positions) {
    if (position.has_height && position.position.h_m != 0.0) {
      heights_m.push_back(position.position.h_m);
    }
  }
  double is_far_m = 0.0;
  double middle_m = 0.0;
  if (!heights_m.empty()) {
    middle_m = Median(heights_m);
    std::vector<double> distances_m;
    for (const double height_m : heights_m) {
      distances_m.push_back(std::abs(height_m - middle_m));
    }
    is_far_m = std::max(kHeightErrorM, kHeightSpreads * Median(distances_m));
  }
  for (CameraPosition& position : *positions) {
    if (position.position.h_m == 0.0 && (heights_m.empty() || std::abs(middle_m) > is_far_m)) {
      position.has_height = false;
    }
  }
}

void FillHeights(const std::optional<double>& default_height_m,
                 std::vector<CameraPosition>* positions, PositionFindings* findings) {
  std::vector<double> heights_m;
  for (const CameraPosition& position : *positions) {
    if (position.has_height) {
      heights_m.push_back(position.position.h_m);
    } else {
      ++findings->num_without_height;
    }
  }
  if (heights_m.empty() && !default_height_m) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("georegistration: none of the {} positions has a height ({}), so the "
                            "map would not stand at the height of the street. State the height of "
                            "the cameras with --camera-height M, or give a table of positions with "
                            "heights",
                            positions->size(), WordsForNoHeight()));
  }
  const double height_m = default_height_m ? *default_height_m : Median(heights_m);
  for (CameraPosition& position : *positions) {
    if (!position.has_height) {
      position.position.h_m = height_m;
      position.has_height = heights_m.empty();
      if (default_height_m) {
        position.height_reference.reset();  // That of the others is not that of the default.
      }
    }
  }
}

}  // namespace

std::vector<std::string> NotesOnPositions(const PositionFindings& findings) {
  std::vector<std::string> notes;
  if (findings.num_at_null_island > 0) {
    notes.push_back(fmt::format("{} positions at 0, 0 are left out", findings.num_at_null_island));
  }
  if (findings.num_without_height > 0) {
    notes.push_back(fmt::format("{} positions have no height ({}); their heights do not count",
                                findings.num_without_height, WordsForNoHeight()));
  }
  return notes;
}

PositionFindings CheckPositions(const std::optional<double>& default_height_m,
                                std::vector<CameraPosition>* positions) {
  PositionFindings findings;
  findings.num_at_null_island = static_cast<int>(std::erase_if(*positions, IsAtNullIsland));
  if (positions->empty()) {
    return findings;
  }
  RequireDifferentPlaces(*positions);
  findings.rounded_to_deg = RoundingOf(*positions);
  RequireFineSteps(findings.rounded_to_deg, *positions);
  MarkMissingHeights(positions);
  FillHeights(default_height_m, positions, &findings);
  return findings;
}

std::optional<std::string> CompareWithExif(const std::string& table_path,
                                           const std::vector<CameraPosition>& table,
                                           const std::vector<CameraPosition>& exif) {
  std::map<std::string, Geodetic> exif_of_name;
  for (const CameraPosition& position : exif) {
    if (!IsAtNullIsland(position)) {
      exif_of_name.emplace(position.image_name, position.position);
    }
  }
  std::vector<double> distances_m, exchanged_m;
  for (const CameraPosition& row : table) {
    const auto found = exif_of_name.find(row.image_name);
    if (found != exif_of_name.end()) {
      const Geodetic exchanged{row.position.lon_rad, row.position.lat_rad, 0.0};
      distances_m.push_back(GroundDistanceM(row.position, found->second));
      exchanged_m.push_back(std::abs(exchanged.lat_deg()) > 90.0
                                ? std::numeric_limits<double>::infinity()
                                : GroundDistanceM(exchanged, found->second));
    }
  }
  if (distances_m.size() < kFewestToJudge) {
    return std::nullopt;
  }
  const double distance_m = Median(std::move(distances_m));
  if (distance_m <= kMaxFromExifM) {
    return std::nullopt;
  }
  const std::string finding =
      fmt::format("the positions of the table are {:.1f} km from those in the EXIF of the photos",
                  1e-3 * distance_m);
  if (Median(std::move(exchanged_m)) <= kMaxFromExifM) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: {}: latitude and longitude have changed places; exchange the two",
                            Printable(table_path), finding));
  }
  return finding + "; the table counts";
}

void RequireNotExchanged(const std::vector<CameraPosition>& positions,
                         const std::function<bool(const Geodetic& place)>& has_map_at) {
  std::vector<double> lats_rad, lons_rad;
  for (const CameraPosition& position : positions) {
    lats_rad.push_back(position.position.lat_rad);
    lons_rad.push_back(position.position.lon_rad);
  }
  const Geodetic stated{Median(std::move(lats_rad)), Median(std::move(lons_rad)), 0.0};
  const Geodetic exchanged{stated.lon_rad, stated.lat_rad, 0.0};
  if (has_map_at(stated) || std::abs(exchanged.lat_deg()) > 90.0 || !has_map_at(exchanged)) {
    return;
  }
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("latitude and longitude of the positions have probably changed places: "
                  "around {:.4f}, {:.4f} the map has nothing, and around {:.4f}, {:.4f} it "
                  "has other sessions. Exchange the two; if the session is right as it is, add it "
                  "with --apart, or make another map if it is the map's that have changed",
                  stated.lat_deg(), stated.lon_deg(), exchanged.lat_deg(), exchanged.lon_deg()));
}

}  // namespace cairn
