#include "ingest/colmap/colmap_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/logging.h"
#include "core/match_names.h"
#include "core/printable.h"
#include "core/scene/triangulate.h"
#include "ingest/colmap/colmap_database.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/descriptor_information.h"
#include "ingest/colmap/model_errors.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxListBytes = uint64_t{256} << 20;

[[noreturn]] void ThrowBadModel(const ColmapInput& input, const std::string& what) {
  throw Error(ErrorCode::kBadInput, fmt::format("COLMAP model {}: {}", input.model_dir, what));
}

// Index into Reconstruction::images by COLMAP's image id; -1 if the image is not read.
using ImageIndex = std::unordered_map<uint32_t, int>;

std::vector<std::string> NamesOf(const std::vector<ColmapImage>& images) {
  std::vector<std::string> names;
  for (const ColmapImage& image : images) {
    names.push_back(image.name);
  }
  return names;
}

// Says that names of one file are not equal to those of the other.
void LogInexact(const NameMatches& matches, const std::vector<std::string>& wanted,
                const std::vector<std::string>& known, const char* where) {
  if (matches.num_inexact > 0) {
    LogInfo("{} image names are written in another way {}, e.g. {}", matches.num_inexact, where,
            InexactExample(matches, wanted, known));
  }
}

// Removes the images that are not wanted. Skips a wanted name that only the database knows, because
// COLMAP did not register that photo. Refuses a name that neither model nor database knows.
void KeepImages(const ColmapInput& input, ColmapDatabase* database,
                std::vector<ColmapImage>* images) {
  // Ordered, so that messages do not depend on the order of the list.
  const std::set<std::string> unique(input.image_names.begin(), input.image_names.end());
  const std::vector<std::string> wanted(unique.begin(), unique.end());
  const std::vector<std::string> known = NamesOf(*images);
  const NameMatches matches = MatchNames(wanted, known);
  LogInexact(matches, wanted, known, "in the model");
  std::vector<bool> is_wanted(images->size(), false);
  std::vector<std::string> missing;
  for (size_t i = 0; i < wanted.size(); ++i) {
    if (const int known_idx = matches.known_of_wanted[i]; known_idx >= 0) {
      is_wanted[known_idx] = true;
    } else {
      missing.push_back(wanted[i]);
    }
  }
  for (const std::string& name : missing) {
    if (!database->HasImage(name)) {
      ThrowBadModel(input,
                    fmt::format("the requested image {} is neither in the model nor in {}; the "
                                "images of the model are {}",
                                Excerpt(name), input.database_path, ExampleNames(known)));
    }
  }
  if (missing.size() == wanted.size()) {
    ThrowBadModel(input, fmt::format("it has none of the {} requested images", wanted.size()));
  }
  if (!missing.empty()) {
    LogWarning(
        "{} of the {} requested images are skipped because COLMAP did not register them, e.g. {}",
        missing.size(), wanted.size(), Excerpt(missing.front()));
  }
  std::vector<ColmapImage> kept;
  for (size_t i = 0; i < images->size(); ++i) {
    if (is_wanted[i]) {
      kept.push_back(std::move((*images)[i]));
    }
  }
  *images = std::move(kept);
}

// Returns for each image of the model its name in the database.
std::vector<std::string> NamesInDatabase(const ColmapInput& input,
                                         const std::vector<ColmapImage>& images,
                                         ColmapDatabase* database) {
  const std::vector<std::string> names = NamesOf(images);
  const std::vector<std::string> known = database->ImageNames();
  const NameMatches matches = MatchNames(names, known);
  LogInexact(matches, names, known, "in the database");
  std::vector<std::string> in_database;
  for (size_t i = 0; i < names.size(); ++i) {
    if (matches.known_of_wanted[i] < 0) {
      ThrowBadModel(input,
                    fmt::format("image {} is not in {}, which has {}; check that the model "
                                "was built from this database",
                                Excerpt(names[i]), input.database_path, ExampleNames(known)));
    }
    in_database.push_back(known[matches.known_of_wanted[i]]);
  }
  return in_database;
}

ReconImage ReadImage(const ColmapInput& input, const ColmapImage& source,
                     const std::string& name_in_database, int camera_idx,
                     ColmapDatabase* database) {
  const ColmapPosePrior prior = database->ReadPosePrior(name_in_database);
  ReconImage image{.name = source.name,
                   .camera_idx = camera_idx,
                   .cam_from_world = source.cam_from_world,
                   .features = database->ReadFeatures(name_in_database),
                   .gps = prior.gps,
                   .gps_accuracy_m = prior.gps_accuracy_m,
                   .down_in_cam = prior.down_in_cam};
  if (source.pixels.empty()) {  // Writers of poses alone leave the line of keypoints empty.
    return image;
  }
  if (image.features.keypoints.size() != source.pixels.size()) {
    ThrowBadModel(
        input,
        fmt::format("image {} has {} keypoints here but {} in {}; check that the model was built "
                    "from this database",
                    Excerpt(source.name), source.pixels.size(), image.features.keypoints.size(),
                    input.database_path));
  }
  // Uses the model's pixels instead of the database's, because they fit the cameras even after
  // image_undistorter.
  for (size_t i = 0; i < source.pixels.size(); ++i) {
    image.features.keypoints[i].x_px = source.pixels[i].x();
    image.features.keypoints[i].y_px = source.pixels[i].y();
  }
  return image;
}

ReconImage PoseAlone(const ColmapImage& source, int camera_idx) {
  ReconImage image;
  image.name = source.name;
  image.camera_idx = camera_idx;
  image.cam_from_world = source.cam_from_world;
  return image;
}

// Fills the cameras, the images and the index of the read images. Without a database, images have
// no features.
void ReadImages(const ColmapInput& input, const ColmapModel& model, ColmapDatabase* database,
                Reconstruction* reconstruction, ImageIndex* index) {
  std::unordered_map<uint32_t, int> camera_idx_of_id;
  for (const auto& [camera_id, camera] : model.cameras) {
    camera_idx_of_id[camera_id] = static_cast<int>(reconstruction->cameras.size());
    reconstruction->cameras.push_back(camera);
  }
  std::vector<std::string> names;
  if (database != nullptr) {
    names = NamesInDatabase(input, model.images, database);
  }
  for (size_t i = 0; i < model.images.size(); ++i) {
    const ColmapImage& image = model.images[i];
    const auto camera_idx = camera_idx_of_id.find(image.camera_id);
    if (const auto unsupported = model.unsupported_cameras.find(image.camera_id);
        unsupported != model.unsupported_cameras.end()) {
      ThrowBadModel(input, fmt::format("image {} has camera {}: {}", Excerpt(image.name),
                                       image.camera_id, unsupported->second));
    }
    if (camera_idx == camera_idx_of_id.end()) {
      ThrowBadModel(input, fmt::format("image {} refers to camera {}, which does not exist",
                                       Excerpt(image.name), image.camera_id));
    }
    (*index)[image.image_id] = static_cast<int>(reconstruction->images.size());
    reconstruction->images.push_back(
        database == nullptr ? PoseAlone(image, camera_idx->second)
                            : ReadImage(input, image, names[i], camera_idx->second, database));
  }
}

// The observations of a point in the read images; only the first in each image.
std::vector<ReconObservation> ReadTrack(const ColmapInput& input, const ColmapPoint& point,
                                        const ImageIndex& index,
                                        const Reconstruction& reconstruction) {
  std::vector<ReconObservation> observations;
  for (const auto& [image_id, keypoint_idx] : point.track) {
    const auto found = index.find(image_id);
    if (found == index.end()) {
      ThrowBadModel(input,
                    fmt::format("a point is observed in image {}, which does not exist", image_id));
    }
    if (found->second < 0) {
      continue;
    }
    const ReconImage& image = reconstruction.images[found->second];
    if (keypoint_idx >= image.features.keypoints.size()) {
      ThrowBadModel(input,
                    fmt::format("a point refers to keypoint {} of {} in image {}", keypoint_idx,
                                image.features.keypoints.size(), Excerpt(image.name)));
    }
    observations.push_back({found->second, static_cast<int>(keypoint_idx)});
  }
  std::stable_sort(observations.begin(), observations.end(),
                   [](const auto& a, const auto& b) { return a.image_idx < b.image_idx; });
  const auto twins =
      std::unique(observations.begin(), observations.end(),
                  [](const auto& a, const auto& b) { return a.image_idx == b.image_idx; });
  observations.erase(twins, observations.end());
  return observations;
}

// Gives each keypoint to the first point that it sees.
class KeypointOwners {
 public:
  explicit KeypointOwners(const Reconstruction& reconstruction) {
    for (const ReconImage& image : reconstruction.images) {
      is_owned_.emplace_back(image.features.keypoints.size(), false);
    }
  }

  // Removes the observations by keypoints of earlier points.
  void TakeFrom(std::vector<ReconObservation>* observations) {
    num_taken_ += std::erase_if(*observations, [&](const ReconObservation& observation) {
      std::vector<bool>& of_image = is_owned_[static_cast<size_t>(observation.image_idx)];
      const auto keypoint_idx = static_cast<size_t>(observation.keypoint_idx);
      const bool is_owned = of_image[keypoint_idx];
      of_image[keypoint_idx] = true;
      return is_owned;
    });
  }
  size_t num_taken() const { return num_taken_; }

 private:
  std::vector<std::vector<bool>> is_owned_;  // By image and keypoint.
  size_t num_taken_ = 0;
};

// Queries need no points, maps do.
void SayWithoutPoints(const ColmapInput& input, const ColmapModel& model) {
  if (model.points.empty()) {
    LogWarning(
        "COLMAP model {}: it has poses and no 3D points that images see; a map needs points, which "
        "`colmap point_triangulator` makes of the photos, the matches and these poses",
        input.model_dir);
  }
}

void ReadLandmarks(const ColmapInput& input, const ColmapModel& model, const ImageIndex& index,
                   Reconstruction* reconstruction) {
  const bool restricted = !input.image_names.empty();
  KeypointOwners owners(*reconstruction);
  ModelErrors errors;
  for (const ColmapPoint& point : model.points) {
    ReconLandmark landmark{point.x_in_world, ReadTrack(input, point, index, *reconstruction)};
    if (landmark.observations.size() >= 2) {
      owners.TakeFrom(&landmark.observations);
    }
    if (landmark.observations.size() < 2) {
      continue;
    }
    errors.Add(*reconstruction, landmark);
    if (restricted) {
      const auto x_in_world = TriangulatePoint(PointObservationsOf(*reconstruction, landmark));
      if (!x_in_world) {
        continue;
      }
      landmark.x_in_world = *x_in_world;
    }
    reconstruction->landmarks.push_back(std::move(landmark));
  }
  if (const auto fault = errors.Fault()) {
    ThrowBadModel(input, *fault);
  }
  if (owners.num_taken() > 0) {
    LogWarning("{}: {} observations are left out because their keypoints see an earlier point, too",
               input.model_dir, owners.num_taken());
  }
}

// Returns the ids of the model's images, none of which is read yet.
ImageIndex IndexOf(const ColmapInput& input, const ColmapModel& model) {
  ImageIndex index;
  std::unordered_map<std::string_view, uint32_t> id_of_name;
  for (const ColmapImage& image : model.images) {
    if (!index.emplace(image.image_id, -1).second) {
      ThrowBadModel(input, fmt::format("image id {} occurs twice", image.image_id));
    }
    if (const auto [first, is_new] = id_of_name.emplace(image.name, image.image_id); !is_new) {
      ThrowBadModel(input, fmt::format("the image {} occurs twice, with the ids {} and {}",
                                       Excerpt(image.name), first->second, image.image_id));
    }
  }
  return index;
}

void SortByName(ColmapModel* model) {
  std::sort(model->images.begin(), model->images.end(),
            [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
}

}  // namespace

Reconstruction ReadColmapPoses(const std::string& model_dir) {
  ColmapInput input;
  input.model_dir = FindColmapModel(model_dir);
  ColmapModel model = ReadColmapModel(input.model_dir);
  ImageIndex index = IndexOf(input, model);
  SortByName(&model);
  Reconstruction reconstruction;
  ReadImages(input, model, /*database=*/nullptr, &reconstruction, &index);
  return reconstruction;
}

Reconstruction ReadColmap(const ColmapInput& input_with_folder) {
  ColmapInput input = input_with_folder;
  input.model_dir = FindColmapModel(input.model_dir);
  ColmapModel model = ReadColmapModel(input.model_dir);
  ImageIndex index = IndexOf(input, model);
  SayWithoutPoints(input, model);
  ColmapDatabase database(input.database_path);
  if (!input.image_names.empty()) {
    KeepImages(input, &database, &model.images);
  }
  SortByName(&model);
  Reconstruction reconstruction;
  ReadImages(input, model, &database, &reconstruction, &index);
  ReadLandmarks(input, model, index, &reconstruction);
  reconstruction.Validate();
  try {
    RequireInformation(reconstruction);
  } catch (const Error& error) {
    ThrowBadModel(input, fmt::format("{} ({})", error.what(), input.database_path));
  }
  LogDebug("{}: {} images, {} of {} landmarks", input.model_dir, reconstruction.images.size(),
           reconstruction.landmarks.size(), model.points.size());
  return reconstruction;
}

std::vector<std::string> ReadImageList(const std::string& path) {
  std::istringstream file(ReadTextFile(path, kMaxListBytes));
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    constexpr std::string_view kBlanks = " \t\r";
    const size_t begin = line.find_first_not_of(kBlanks);
    if (begin == std::string::npos || line[begin] == '#') {
      continue;
    }
    names.push_back(line.substr(begin, line.find_last_not_of(kBlanks) + 1 - begin));
  }
  return names;
}

}  // namespace cairn
