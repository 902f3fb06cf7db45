#include "cli/photo_orientations.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "core/images/exif.h"
#include "core/images/gray_image.h"
#include "core/images/image_header.h"
#include "core/images/orient_image.h"
#include "core/logging.h"
#include "core/printable.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr size_t kNumToFind = 3;

// Names come from a file that anybody may have made: they may not lead out of the folder.
bool StaysInside(const fs::path& name) {
  return name.is_relative() &&
         std::none_of(name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

bool HasPhotos(const fs::path& folder, const Reconstruction& reconstruction) {
  const size_t count = std::min(kNumToFind, reconstruction.images.size());
  for (size_t i = 0; i < count; ++i) {
    std::error_code ignored;
    const fs::path name = reconstruction.images[i].name;
    if (!StaysInside(name) || !fs::is_regular_file(folder / name, ignored)) {
      return false;
    }
  }
  return count > 0;
}

// The orientation of the pixels in which the model's camera sees the photo, if it is known.
std::optional<int> OrientationFor(const std::vector<uint8_t>& photo, const Camera& camera) {
  const ImageHeader header = ParseImageHeader(photo);
  if (header.exif.empty()) {
    return std::nullopt;
  }
  const int orientation = ReadExif(photo).orientation;
  const bool photo_lies = header.width_px > header.height_px;
  const bool model_lies = camera.width_px() > camera.height_px();
  if (photo_lies == model_lies) {
    return orientation;
  }
  return SwapsSides(orientation) ? std::optional<int>(1) : std::nullopt;
}

}  // namespace

std::string FindPhotoFolder(const Reconstruction& reconstruction, const std::string& database_path,
                            const std::string& model_dir) {
  const fs::path beside = fs::absolute(database_path).parent_path();
  const fs::path above = (fs::absolute(model_dir) / "").parent_path().parent_path();
  for (const fs::path& root : {beside, above, above.parent_path()}) {
    for (const char* folder : {"images", "photos", ""}) {
      if (HasPhotos(root / folder, reconstruction)) {
        return (root / folder).string();
      }
    }
  }
  return "";
}

ImageOrientations ReadOrientations(const std::string& folder,
                                   const Reconstruction& reconstruction) {
  ImageOrientations orientations;
  for (const ReconImage& image : reconstruction.images) {
    orientations.emplace_back();
    if (!StaysInside(image.name)) {
      continue;
    }
    try {
      orientations.back() = OrientationFor(ReadImageBytes((fs::path(folder) / image.name).string()),
                                           reconstruction.cameras[image.camera_idx]);
    } catch (const Error& e) {
      LogDebug("{}: {}", Excerpt(image.name), e.what());
    }
  }
  return orientations;
}

}  // namespace cairn
