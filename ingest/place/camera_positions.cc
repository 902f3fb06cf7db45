#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/logging.h"
#include "core/match_names.h"
#include "core/printable.h"
#include "ingest/place/georegister.h"
#include "ingest/place/position_table.h"

namespace cairn {
namespace {

// A sentence about the names that MatchNames does not find; nothing if it finds all.
std::optional<std::string> NoteOnUnknown(const std::vector<std::string>& wanted,
                                         const NameMatches& matches, const char* known) {
  std::vector<std::string> unknown;
  for (size_t i = 0; i < wanted.size(); ++i) {
    if (matches.known_of_wanted[i] < 0) {
      unknown.push_back(wanted[i]);
    }
  }
  if (unknown.empty()) {
    return std::nullopt;
  }
  return fmt::format("{} of {} positions in the table are of no {}: {}", unknown.size(),
                     wanted.size(), known, ExampleNames(unknown));
}

bool AreSame(const CameraPosition& a, const CameraPosition& b) {
  return a.position.lat_rad == b.position.lat_rad && a.position.lon_rad == b.position.lon_rad &&
         a.position.h_m == b.position.h_m && a.accuracy_m == b.accuracy_m &&
         a.has_height == b.has_height;
}

// Two rows of one photo have to say the same.
void RequireSame(const CameraPosition& first, const CameraPosition& second,
                 const std::array<std::string, 2>& names, const std::string& path = "") {
  if (!AreSame(first, second)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}{}two rows, {} and {}, are positions of the photo {}; leave one",
                            Printable(path), path.empty() ? "" : ": ", Excerpt(names[0]),
                            Excerpt(names[1]), Excerpt(first.image_name)));
  }
}

}  // namespace

std::vector<CameraPosition> ReadCameraPositions(const std::string& path,
                                                double default_accuracy_m) {
  PositionTable table(path, {"image", "lat_deg", "lon_deg", "h_m"});
  std::vector<CameraPosition> positions;
  std::map<std::string, size_t> position_of_name;
  int num_empty = 0;
  while (table.NextRow()) {
    if (!table.Has("lat_deg") && !table.Has("lon_deg")) {
      ++num_empty;  // A photo without GPS.
      continue;
    }
    CameraPosition position;
    position.image_name = table.Text("image");
    position.position = table.Position(position.image_name);
    position.accuracy_m = table.AccuracyOr(default_accuracy_m);
    position.has_height = table.Has("h_m");
    position.height_reference = table.height_reference();
    const auto [first, is_new] =
        position_of_name.try_emplace(position.image_name, positions.size());
    if (is_new) {
      positions.push_back(std::move(position));
    } else if (!AreSame(positions[first->second], position)) {
      table.Throw(fmt::format("the photo {} has another position in an earlier line; leave one",
                              Excerpt(position.image_name)));
    }
  }
  if (positions.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: there is no position below the header", path));
  }
  const bool has_height = std::any_of(positions.begin(), positions.end(),
                                      [](const auto& position) { return position.has_height; });
  if (has_height && table.HasAltitudesOfExif()) {
    LogWarning(
        "{}: the heights of GPSAltitude are above sea level if cameras wrote them; --height msl "
        "says that they are, and --height ellipsoid that they are not",
        Printable(path));
  }
  if (num_empty > 0) {
    LogInfo("{}: {} of {} rows have no position", Printable(path), num_empty,
            positions.size() + static_cast<size_t>(num_empty));
  }
  return positions;
}

std::vector<CameraPosition> ReadPositionsOfPhotos(const std::string& path,
                                                  const std::vector<std::string>& photo_names,
                                                  std::vector<std::string>* notes,
                                                  double default_accuracy_m) {
  std::vector<CameraPosition> positions = ReadCameraPositions(path, default_accuracy_m);
  std::vector<std::string> wanted;
  for (const CameraPosition& position : positions) {
    wanted.push_back(position.image_name);
  }
  const NameMatches matches = MatchNames(wanted, photo_names);
  std::vector<CameraPosition> named;
  std::map<std::string, size_t> row_of_known;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (matches.known_of_wanted[i] < 0) {
      continue;
    }
    const std::string& name = photo_names[matches.known_of_wanted[i]];
    const auto [first, is_new] = row_of_known.try_emplace(name, i);
    if (!is_new) {
      RequireSame(positions[first->second], positions[i], {wanted[first->second], wanted[i]}, path);
      continue;
    }
    positions[i].image_name = name;
    named.push_back(positions[i]);
  }
  if (named.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: none of its names ({}) is that of a photo ({})", Printable(path),
                            ExampleNames(wanted), ExampleNames(photo_names)));
  }
  if (matches.num_inexact > 0) {
    notes->push_back(
        fmt::format("{} positions have names that the photos write in another way, e.g. {}",
                    matches.num_inexact, InexactExample(matches, wanted, photo_names)));
  }
  if (const auto note = NoteOnUnknown(wanted, matches, "photo")) {
    notes->push_back(*note);
  }
  return named;
}

std::optional<std::string> NameAfterImages(const Reconstruction& reconstruction,
                                           std::vector<CameraPosition>* positions) {
  std::vector<std::string> image_names;
  for (const ReconImage& image : reconstruction.images) {
    image_names.push_back(image.name);
  }
  std::vector<std::string> names;
  for (const CameraPosition& position : *positions) {
    names.push_back(position.image_name);
  }
  const NameMatches matches = MatchNames(names, image_names);
  int num_matches = 0;
  std::vector<CameraPosition> named;
  std::map<int, size_t> row_of_image;
  for (size_t i = 0; i < names.size(); ++i) {
    CameraPosition& position = (*positions)[i];
    if (const int image_idx = matches.known_of_wanted[i]; image_idx >= 0) {
      const auto [first, is_new] = row_of_image.try_emplace(image_idx, i);
      position.image_name = image_names[image_idx];
      ++num_matches;
      if (!is_new) {
        RequireSame((*positions)[first->second], position, {names[first->second], names[i]});
        continue;
      }
    }
    named.push_back(position);
  }
  if (num_matches == 0) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("none of the {} known positions belongs to one of the {} images: the "
                            "positions are those of {}, the images are {}",
                            names.size(), image_names.size(), ExampleNames(names),
                            ExampleNames(image_names)));
  }
  if (matches.num_inexact > 0) {
    LogInfo("{} positions have names that are written in another way in the model, e.g. {}",
            matches.num_inexact, InexactExample(matches, names, image_names));
  }
  *positions = std::move(named);
  return NoteOnUnknown(names, matches, "image of the model");
}

std::vector<CameraPosition> GpsPositions(const Reconstruction& reconstruction, double accuracy_m) {
  std::vector<CameraPosition> positions;
  for (const ReconImage& image : reconstruction.images) {
    if (image.gps) {
      positions.push_back({image.name, *image.gps, image.gps_accuracy_m.value_or(accuracy_m)});
    }
  }
  return positions;
}

void MakeHeightsEllipsoidal(std::optional<HeightReference> chosen, HeightReference usual,
                            std::vector<CameraPosition>* positions) {
  for (CameraPosition& position : *positions) {
    const HeightReference stated = position.height_reference.value_or(usual);
    position.position = WithEllipsoidalHeight(position.position, chosen.value_or(stated));
    position.height_reference = HeightReference::kEllipsoid;
  }
}

}  // namespace cairn
