// The photos of a rig's other cameras, as `localize --rig` names them.
#ifndef CAIRN_CLI_RIG_PHOTOS_H_
#define CAIRN_CLI_RIG_PHOTOS_H_

#include <string>
#include <vector>

#include "engine/query/localize_query.h"
#include "ingest/images/gray_image.h"

namespace cairn {

// A photo by a camera of the rig; the camera has no features yet.
struct RigPhoto {
  RigCamera camera;
  Photo photo;
};

// Reads a JSON array of {"camera", "camFromFirst", "image"}: the first two as in the `rig` of
// POST /v1/localize (docs/http.md), `image` a file's path, relative to the folder of `path`. Throws
// Error with the path and what is wrong.
std::vector<RigPhoto> ReadRigPhotos(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_CLI_RIG_PHOTOS_H_
