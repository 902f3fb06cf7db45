// Finds the photos of a reconstruction, whose EXIF says more than COLMAP reads.
#ifndef CAIRN_CLI_MODEL_PHOTOS_H_
#define CAIRN_CLI_MODEL_PHOTOS_H_

#include <string>
#include <vector>

#include "core/scene/reconstruction.h"
#include "ingest/place/georegister.h"

namespace cairn {

// The folder in which the photos of a model usually lie: `images` or `photos` beside the database
// or above the model, or the folder of the database itself. Empty if none of them has the first
// photos of the reconstruction.
std::string FindPhotoFolder(const Reconstruction& reconstruction, const std::string& database_path,
                            const std::string& model_dir);

// Throws Error(kNotFound) if `folder`, which the user named, is no folder. Logs a warning, with the
// numbers of both, if it has none of the reconstruction's photos.
void CheckPhotoFolder(const std::string& folder, const Reconstruction& reconstruction);

// What the EXIF of photos says, by image of the reconstruction.
struct PhotoExif {
  ImageOrientations orientations;
  std::vector<bool>
      gps_is_void;  // The receiver marked the position, which COLMAP takes all the same.
};

// Reads the photos in `folder`. An image without a photo or without EXIF has no orientation. A
// photo whose sides are exchanged relative to the camera of the model was turned upright before
// COLMAP read it, and gets orientation 1.
PhotoExif ReadPhotoExif(const std::string& folder, const Reconstruction& reconstruction);

}  // namespace cairn

#endif  // CAIRN_CLI_MODEL_PHOTOS_H_
