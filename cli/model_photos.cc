#include "cli/model_photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
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

bool HasPhoto(const fs::path& folder, const ReconImage& image) {
  std::error_code ignored;
  return StaysInside(image.name) && fs::is_regular_file(folder / image.name, ignored);
}

bool HasPhotos(const fs::path& folder, const Reconstruction& reconstruction) {
  const size_t count = std::min(kNumToFind, reconstruction.images.size());
  for (size_t i = 0; i < count; ++i) {
    if (!HasPhoto(folder, reconstruction.images[i])) {
      return false;
    }
  }
  return count > 0;
}

int64_t NumFilesIn(const fs::path& folder) {
  int64_t num_files = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    num_files += entry->is_regular_file(ignored) ? 1 : 0;
  }
  return num_files;
}

// The orientation of the pixels in which the model's camera sees the photo, if it is known.
std::optional<int> OrientationFor(const ImageHeader& header, int orientation,
                                  const Camera& camera) {
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

void CheckPhotoFolder(const std::string& folder, const Reconstruction& reconstruction) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("--photos {}: there is no such folder", Printable(folder)));
  }
  const bool has_any =
      std::any_of(reconstruction.images.begin(), reconstruction.images.end(),
                  [&](const ReconImage& image) { return HasPhoto(folder, image); });
  if (!has_any && !reconstruction.images.empty()) {
    LogWarning(
        "--photos {}: none of the {} photos of the model is among its {} files, so the EXIF does "
        "not say how they were held; the model has names such as {}",
        Printable(folder), reconstruction.images.size(), NumFilesIn(folder),
        Excerpt(reconstruction.images.front().name));
  }
}

PhotoExif ReadPhotoExif(const std::string& folder, const Reconstruction& reconstruction) {
  PhotoExif result;
  for (const ReconImage& image : reconstruction.images) {
    result.orientations.emplace_back();
    result.gps_is_void.push_back(false);
    if (!StaysInside(image.name)) {
      continue;
    }
    try {
      const std::vector<uint8_t> photo = ReadImageBytes((fs::path(folder) / image.name).string());
      const ImageHeader header = ParseImageHeader(photo);
      if (!header.HasExif()) {
        continue;
      }
      const ExifInfo exif = ReadExif(photo);
      result.orientations.back() =
          OrientationFor(header, exif.orientation, reconstruction.cameras[image.camera_idx]);
      result.gps_is_void.back() = exif.gps_is_void;
    } catch (const Error& e) {
      LogDebug("{}: {}", Excerpt(image.name), e.what());
    }
  }
  return result;
}

}  // namespace cairn
