// Finds the photos of a reconstruction, to learn from their EXIF how they were held.
#ifndef CAIRN_CLI_PHOTO_ORIENTATIONS_H_
#define CAIRN_CLI_PHOTO_ORIENTATIONS_H_

#include <string>

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

// The orientations of the images whose photos are in `folder` and have EXIF. A photo whose sides
// are exchanged relative to the camera of the model was turned upright before COLMAP read it, and
// gets 1. Photos that cannot be read stay without.
ImageOrientations ReadOrientations(const std::string& folder, const Reconstruction& reconstruction);

}  // namespace cairn

#endif  // CAIRN_CLI_PHOTO_ORIENTATIONS_H_
