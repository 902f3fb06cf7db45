// Reads COLMAP sparse models (binary and text) together with the keypoints and descriptors of their
// database.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_READER_H_
#define CAIRN_INGEST_COLMAP_COLMAP_READER_H_

#include <string>
#include <vector>

#include "core/scene/reconstruction.h"

namespace cairn {

struct ColmapInput {
  // Folder of {cameras,images,points3D}.{bin,txt}; .bin is preferred. If it has no model, the only
  // model below it, e.g. in sparse/0.
  std::string model_dir;
  std::string database_path;  // database.db with keypoints, descriptors and optional GPS priors.
  // If not empty, only the images with these names are read; MatchNames (core/match_names.h) finds
  // them in the model. Names that only the database knows (COLMAP did not register the image) are
  // skipped with a warning. Landmarks with fewer than two observations in these images are dropped.
  // The other landmarks are triangulated again from these observations alone, so that no
  // observation in another image has an influence.
  std::vector<std::string> image_names;
};

// Finds the images of the model in the database by MatchNames, too.
//
// Returns the images in the order of their names, whatever their order in the files; a map numbers
// its keyframes in this order. Throws Error(kNotFound) for missing files. Throws Error(kBadInput)
// that names file, offset and fault for malformed files, for an unsupported camera model, for
// images without keypoints or descriptors in the database, for descriptors that carry no
// information, for names in `image_names` that neither
// model nor database knows, and if the model has none of the named images.
Reconstruction ReadColmap(const ColmapInput& input);

// Reads the cameras and the poses alone. The images, in the order of their names, have no features,
// and there are no landmarks. Throws as ReadColmap does for the model.
Reconstruction ReadColmapPoses(const std::string& model_dir);

// Reads one image name per line from a file of at most 256 MiB. Ignores a byte order mark, blank
// lines and lines that begin with '#'.
std::vector<std::string> ReadImageList(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_READER_H_
