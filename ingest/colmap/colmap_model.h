// The three files of a COLMAP sparse model, as stored on disk.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_MODEL_H_
#define CAIRN_INGEST_COLMAP_COLMAP_MODEL_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"

namespace cairn {

struct ColmapImage {
  uint32_t image_id = 0;
  std::string name;
  uint32_t camera_id = 0;
  Rigid3d cam_from_world;
  std::vector<Eigen::Vector2f> pixels;  // One for each keypoint of the image.
};

struct ColmapPoint {
  Eigen::Vector3d x_in_world;
  std::vector<std::pair<uint32_t, uint32_t>> track;  // Image id, keypoint index.
};

struct ColmapModel {
  std::map<uint32_t, Camera> cameras;
  // By id, why Cairn does not support the camera model; names the model.
  std::map<uint32_t, std::string> unsupported_cameras;
  std::vector<ColmapImage> images;  // In file order.
  std::vector<ColmapPoint> points;  // In file order; without points that no image sees.
};

// An image with more keypoints is refused.
inline constexpr size_t kMaxColmapKeypoints = 2'000'000;

// Returns the folder of the model: `dir`, or the only folder below it that has a model, as a
// project has with sparse/0. Throws Error(kNotFound) if there is none. Throws Error(kBadInput),
// which names the models and their numbers of images, if there are several.
std::string FindColmapModel(const std::string& dir);

// Reads {cameras,images,points3D} with the extension .bin if all three files exist, else .txt.
// Ignores the rigs and frames of COLMAP 3.12 and later, because `images` still has the full pose of
// each image. Checks the form of the files and every number, but not whether ids refer to existing
// objects. The memory grows with the content that was read, not with what a count or the size of a
// file says. Throws Error(kNotFound) if neither set is complete, and Error(kBadInput) that names
// the file and the byte offset (for text: the line).
ColmapModel ReadColmapModel(const std::string& model_dir);

// Readers for the two encodings, used by the functions above.
ColmapModel ReadBinaryColmapModel(const std::string& model_dir);
ColmapModel ReadTextColmapModel(const std::string& model_dir);
uint64_t CountImagesOfBinaryModel(const std::string& model_dir);
uint64_t CountImagesOfTextModel(const std::string& model_dir);

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_MODEL_H_
