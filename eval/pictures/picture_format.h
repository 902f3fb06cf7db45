// The file formats of pictures.
#ifndef CAIRN_EVAL_PICTURES_PICTURE_FORMAT_H_
#define CAIRN_EVAL_PICTURES_PICTURE_FORMAT_H_

#include <string>

namespace cairn {

// Checks an output path before the work begins. Throws Error(kInvalidArgument), which names
// `option`, unless the path's extension belongs to a supported picture format.
void RequirePictureFormat(const std::string& option, const std::string& path);

// The extension of a path in lower case: ".png", ".jpg", ".jpeg" or ".ppm". Throws Error(kIo),
// which names the path, for other extensions.
std::string PictureExtension(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_PICTURE_FORMAT_H_
