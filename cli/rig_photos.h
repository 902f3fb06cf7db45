// Reads the photos of a rig's other cameras for `localize --rig`.
#ifndef CAIRN_CLI_RIG_PHOTOS_H_
#define CAIRN_CLI_RIG_PHOTOS_H_

#include <string>
#include <vector>

#include "core/images/gray_image.h"
#include "engine/query/localize_query.h"

namespace cairn {

// A photo and the rig camera that took it; the camera has no features yet.
struct RigPhoto {
  RigCamera camera;
  Photo photo;
};

// Reads a JSON array of {"camera", "camFromFirst", "image"}. The first two members are those of
// `rig` in POST /v1/localize (docs/http.md). `image` is a file path relative to the folder of
// `path`. Throws Error with the path and the fault.
std::vector<RigPhoto> ReadRigPhotos(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_CLI_RIG_PHOTOS_H_
