#include "mapping/session/photo_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "core/error.h"
#include "ingest/place/position_checks.h"
#include "mapping/photos/photo_files.h"

namespace cairn {
namespace {

constexpr size_t kMinPositions = 3;

std::vector<std::string> NamesOf(const std::vector<PhotoFile>& files) {
  std::vector<std::string> names;
  for (const PhotoFile& file : files) {
    names.push_back(file.name);
  }
  return names;
}

// The photos of all folders of the table are compared with its names, so that a name that could be
// of two folders is noticed. Photos that cannot be read are not in `set`, and have no position.
std::vector<CameraPosition> PositionsOfFolders(const MapPhotosInput& input, const PhotoSet& set,
                                               std::vector<std::string>* notes) {
  const std::vector<std::string> names = NamesOf(FindPhotoFiles(input.table_paths));
  const std::string prefix = PrefixOfPhotos(input.paths.front());
  std::set<std::string> own_names;
  for (const MappingPhoto& photo : set.photos) {
    own_names.insert(prefix + photo.name);
  }
  std::vector<CameraPosition> own;
  for (CameraPosition& position : ReadPositionsOfPhotos(input.positions_path, names, notes)) {
    if (own_names.contains(position.image_name)) {
      position.image_name.erase(0, prefix.size());
      own.push_back(std::move(position));
    }
  }
  return own;
}

std::vector<CameraPosition> PositionsOfTable(const MapPhotosInput& input, const PhotoSet& set,
                                             std::vector<std::string>* notes) {
  if (input.table_paths.size() > 1) {
    return PositionsOfFolders(input, set, notes);
  }
  std::vector<std::string> names;
  for (const MappingPhoto& photo : set.photos) {
    names.push_back(photo.name);
  }
  return ReadPositionsOfPhotos(input.positions_path, names, notes);
}

std::vector<CameraPosition> PositionsOfExif(const PhotoSet& set, double accuracy_m) {
  std::vector<CameraPosition> positions;
  for (const MappingPhoto& photo : set.photos) {
    if (photo.gps) {
      positions.push_back({photo.name, *photo.gps, photo.gps_accuracy_m.value_or(accuracy_m),
                           photo.gps_has_height});
    }
  }
  return positions;
}

void RequireEnough(size_t num_positions, const PhotoFolder& folder, bool has_table) {
  if (num_positions < kMinPositions) {
    const std::string num_void =
        has_table || folder.num_void_positions == 0
            ? ""
            : fmt::format(" ({} more have a void one, GPSStatus V)", folder.num_void_positions);
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} of {} photos have a position {}{}, so their place on Earth is "
                            "unknown; give positions of three photos or more: --gps CSV",
                            num_positions, folder.set.photos.size(),
                            has_table ? "in the table" : "in their EXIF", num_void));
  }
}

void AddNotesOnExif(const PhotoFolder& folder, std::vector<std::string>* notes) {
  if (folder.num_without_hemisphere > 0) {
    notes->push_back(fmt::format(
        "{} photos have a position whose hemisphere is not stated (GPSLatitudeRef, "
        "GPSLongitudeRef); they are taken as north and east. If they are not, give --gps CSV",
        folder.num_without_hemisphere));
  }
  if (folder.num_void_positions > 0) {
    notes->push_back(
        fmt::format("{} photos have a position that the receiver marked as void (GPSStatus V); "
                    "these do not count",
                    folder.num_void_positions));
  }
}

void AddNotes(const PositionFindings& findings, size_t num_positions, size_t num_photos,
              std::vector<std::string>* notes) {
  if (num_positions < num_photos) {
    notes->push_back(fmt::format("{} of {} photos have no position; the others place them",
                                 num_photos - num_positions, num_photos));
  }
  std::ranges::move(NotesOnPositions(findings), std::back_inserter(*notes));
}

}  // namespace

std::set<std::string> NamesInTable(const MapPhotosInput& input) {
  if (input.positions_path.empty()) {
    return {};
  }
  const bool has_folders = input.table_paths.size() > 1;
  const std::vector<std::string> names =
      NamesOf(FindPhotoFiles(has_folders ? input.table_paths : input.paths));
  const std::string prefix = has_folders ? PrefixOfPhotos(input.paths.front()) : "";
  std::vector<std::string> notes;
  std::set<std::string> in_table;
  for (const CameraPosition& position :
       ReadPositionsOfPhotos(input.positions_path, names, &notes)) {
    if (position.image_name.starts_with(prefix)) {
      in_table.insert(position.image_name.substr(prefix.size()));
    }
  }
  return in_table;
}

PhotoPlaces FindPhotoPlaces(const MapPhotosInput& input, PhotoFolder* folder,
                            std::vector<std::string>* notes) {
  const bool has_table = !input.positions_path.empty();
  PhotoSet& set = folder->set;
  std::vector<CameraPosition> positions =
      has_table ? PositionsOfTable(input, set, notes) : PositionsOfExif(set, input.gps_accuracy_m);
  RequireEnough(positions.size(), *folder, has_table);
  if (has_table) {
    const auto note = CompareWithExif(input.positions_path, positions,
                                      PositionsOfExif(set, input.gps_accuracy_m));
    if (note) {
      notes->push_back(*note);
    }
  } else {
    AddNotesOnExif(*folder, notes);
  }
  const PositionFindings findings = CheckPositions(input.camera_height_m, &positions);
  RequireEnough(positions.size(), *folder, has_table);  // Without those at 0, 0.
  AddNotes(findings, positions.size(), set.photos.size(), notes);
  MakeHeightsEllipsoidal(input.height,
                         has_table ? HeightReference::kEllipsoid : HeightReference::kMeanSeaLevel,
                         &positions);
  std::map<std::string, CameraPosition> position_of_name;
  for (const CameraPosition& position : positions) {
    position_of_name.emplace(position.image_name, position);
  }
  PhotoPlaces places;
  places.orientations = folder->orientation_of_photo;
  for (MappingPhoto& photo : set.photos) {
    const auto found = position_of_name.find(photo.name);
    places.positions.emplace_back();
    photo.gps.reset();
    if (found == position_of_name.end()) {
      photo.gps_accuracy_m.reset();
      continue;
    }
    places.positions.back() = found->second;
    photo.gps = found->second.position;
    photo.gps_has_height = found->second.has_height;
    // An EXIF that states no accuracy leaves it to the options of the stages.
    if (has_table) {
      photo.gps_accuracy_m = found->second.accuracy_m;
    }
  }
  return places;
}

}  // namespace cairn
