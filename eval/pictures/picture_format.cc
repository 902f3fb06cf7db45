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
namespace {

constexpr std::string_view kExtensions[] = {".png", ".jpg", ".jpeg", ".ppm"};

// Of a path, in lower case.
std::string ExtensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool IsPictureExtension(const std::string& extension) {
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
         std::end(kExtensions);
}

}  // namespace

void RequirePictureFormat(const std::string& option, const std::string& path) {
  if (!IsPictureExtension(ExtensionOf(path))) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' needs a picture extension: {}", option, path,
                            fmt::join(kExtensions, ", ")));
  }
}

std::string PictureExtension(const std::string& path) {
  const std::string extension = ExtensionOf(path);
  if (!IsPictureExtension(extension)) {
    throw Error(ErrorCode::kIo,
                fmt::format("{}: cannot write the picture; its name needs one of {}", path,
                            fmt::join(kExtensions, ", ")));
  }
  return extension;
}

}  // namespace cairn
