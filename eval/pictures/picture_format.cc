#include "eval/pictures/picture_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <string_view>

#include "core/error.h"

namespace cairn {

void RequirePictureFormat(const std::string& option, const std::string& path) {
  constexpr std::string_view kExtensions[] = {".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm"};
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(std::begin(kExtensions), std::end(kExtensions), extension) ==
      std::end(kExtensions)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' needs a picture extension: {}", option, path,
                            fmt::join(kExtensions, ", ")));
  }
}

}  // namespace cairn
