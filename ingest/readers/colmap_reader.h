// Reads COLMAP sparse models (binary and text) with the keypoints and descriptors of their
// database.
#ifndef CAIRN_INGEST_READERS_COLMAP_READER_H_
#define CAIRN_INGEST_READERS_COLMAP_READER_H_

#include <string>
#include <vector>

#include "ingest/sfm/reconstruction.h"

namespace cairn {

struct ColmapInput {
  std::string model_dir;      // Holds {cameras,images,points3D}.{bin,txt}; .bin is preferred.
  std::string database_path;  // database.db with keypoints, descriptors and, if any, GPS priors.
  // If not empty: only these images (by name) are read; observations in others do not leak in.
  // Those that the database knows but the model lacks (COLMAP did not register them) are left out
  // with a warning.
  // Landmarks seen by fewer than two of them are dropped and the rest are triangulated again from
  // the remaining observations alone.
  std::vector<std::string> image_names;
};

// Throws Error(kNotFound) for missing files, Error(kBadInput) naming file, offset and what is wrong
// for malformed ones, for a camera model that is not supported, for images without keypoints or
// descriptors in the database, for names in `image_names` that neither model nor database knows,
// and if the model has none of them.
Reconstruction ReadColmap(const ColmapInput& input);

// Reads one image name per line, of at most 256 MiB; a byte order mark, blank lines and lines
// starting with '#' do not count.
std::vector<std::string> ReadImageList(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_INGEST_READERS_COLMAP_READER_H_
