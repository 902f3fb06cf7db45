// Which files pictures can be written to.
#ifndef CAIRN_EVAL_PICTURES_PICTURE_FORMAT_H_
#define CAIRN_EVAL_PICTURES_PICTURE_FORMAT_H_

#include <string>

namespace cairn {

// Throws Error(kInvalidArgument), naming `option`, unless the path's extension is that of a format
// that pictures can be written in. For use before the work.
void RequirePictureFormat(const std::string& option, const std::string& path);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_PICTURE_FORMAT_H_
