#include "ingest/readers/colmap_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/logging.h"
#include "core/printable.h"
#include "ingest/readers/colmap_database.h"
#include "ingest/readers/colmap_model.h"
#include "ingest/sfm/triangulate.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxListBytes = uint64_t{256} << 20;

[[noreturn]] void ThrowBadModel(const ColmapInput& input, const std::string& what) {
  throw Error(ErrorCode::kBadInput, fmt::format("COLMAP model {}: {}", input.model_dir, what));
}

// Index into Reconstruction::images by COLMAP's image id; -1 if the image is not read.
using ImageIndex = std::unordered_map<uint32_t, int>;

// Removes the images that are not wanted. Skips a wanted name that only the database knows, because
// COLMAP did not register that photo. Refuses a name that neither model nor database knows.
void KeepImages(const ColmapInput& input, ColmapDatabase* database,
                std::vector<ColmapImage>* images) {
  const std::unordered_set<std::string> wanted(input.image_names.begin(), input.image_names.end());
  // Ordered, so that messages do not depend on hashing.
  std::set<std::string> missing(wanted.begin(), wanted.end());
  for (const ColmapImage& image : *images) {
    missing.erase(image.name);
  }
  for (const std::string& name : missing) {
    if (!database->HasImage(name)) {
      ThrowBadModel(input, fmt::format("the requested image {} is neither in the model nor in {}",
                                       Excerpt(name), input.database_path));
    }
  }
  if (missing.size() == wanted.size()) {
    ThrowBadModel(input, fmt::format("it has none of the {} requested images", wanted.size()));
  }
  if (!missing.empty()) {
    LogWarning(
        "{} of the {} requested images are skipped because COLMAP did not register them, e.g. {}",
        missing.size(), wanted.size(), Excerpt(*missing.begin()));
  }
  std::erase_if(*images, [&](const ColmapImage& image) { return !wanted.contains(image.name); });
}

ReconImage ReadImage(const ColmapInput& input, const ColmapImage& source, int camera_idx,
                     ColmapDatabase* database) {
  ReconImage image{.name = source.name,
                   .camera_idx = camera_idx,
                   .cam_from_world = source.cam_from_world,
                   .features = database->ReadFeatures(source.name),
                   .gps = database->ReadGps(source.name)};
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

// Fills the cameras, the images and the index of the read images.
void ReadImages(const ColmapInput& input, const ColmapModel& model, ColmapDatabase* database,
                Reconstruction* reconstruction, ImageIndex* index) {
  std::unordered_map<uint32_t, int> camera_idx_of_id;
  for (const auto& [camera_id, camera] : model.cameras) {
    camera_idx_of_id[camera_id] = static_cast<int>(reconstruction->cameras.size());
    reconstruction->cameras.push_back(camera);
  }
  for (const ColmapImage& image : model.images) {
    const auto camera_idx = camera_idx_of_id.find(image.camera_id);
    if (camera_idx == camera_idx_of_id.end()) {
      ThrowBadModel(input, fmt::format("image {} refers to camera {}, which does not exist",
                                       Excerpt(image.name), image.camera_id));
    }
    (*index)[image.image_id] = static_cast<int>(reconstruction->images.size());
    reconstruction->images.push_back(ReadImage(input, image, camera_idx->second, database));
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

void ReadLandmarks(const ColmapInput& input, const ColmapModel& model, const ImageIndex& index,
                   Reconstruction* reconstruction) {
  const bool restricted = !input.image_names.empty();
  for (const ColmapPoint& point : model.points) {
    ReconLandmark landmark{point.x_in_world, ReadTrack(input, point, index, *reconstruction)};
    if (landmark.observations.size() < 2) {
      continue;
    }
    if (restricted) {
      const auto x_in_world = TriangulatePoint(ViewsOf(*reconstruction, landmark));
      if (!x_in_world) {
        continue;
      }
      landmark.x_in_world = *x_in_world;
    }
    reconstruction->landmarks.push_back(std::move(landmark));
  }
}

}  // namespace

Reconstruction ReadColmap(const ColmapInput& input) {
  ColmapModel model = ReadColmapModel(input.model_dir);
  ImageIndex index;
  for (const ColmapImage& image : model.images) {
    if (!index.emplace(image.image_id, -1).second) {
      ThrowBadModel(input, fmt::format("image id {} occurs twice", image.image_id));
    }
  }
  ColmapDatabase database(input.database_path);
  if (!input.image_names.empty()) {
    KeepImages(input, &database, &model.images);
  }
  std::sort(model.images.begin(), model.images.end(),
            [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  Reconstruction reconstruction;
  ReadImages(input, model, &database, &reconstruction, &index);
  ReadLandmarks(input, model, index, &reconstruction);
  reconstruction.Validate();
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
