#include "cli/rig_photos.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/wire/json_file.h"
#include "core/wire/json_members.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxRigBytes = uint64_t{1} << 20;

RigPhoto ReadRigPhoto(const JsonReader& element, const std::filesystem::path& folder) {
  element.RequireOnly({"camera", "camFromFirst", "image"});
  RigPhoto photo;
  photo.camera = ReadRigCamera(element);
  const JsonReader image = element.At("image");
  const std::string image_path = (folder / image.String()).string();
  photo.photo = ReadPhoto(image_path);
  const int width_px = photo.photo.image.picture_width_px();
  const int height_px = photo.photo.image.picture_height_px();
  const Camera& camera = photo.camera.camera;
  if (camera.width_px() != width_px || camera.height_px() != height_px) {
    image.Fail(fmt::format("has {} x {} pixels, but its camera's images have {} x {}", width_px,
                           height_px, camera.width_px(), camera.height_px()));
  }
  return photo;
}

}  // namespace

std::vector<RigPhoto> ReadRigPhotos(const std::string& path) {
  return ReadJsonFile(path, kMaxRigBytes, {}, [&](const JsonReader& json) {
    std::vector<RigPhoto> photos;
    for (const JsonReader& element : json.Elements(1, RigCamera::kMaxOthers)) {
      photos.push_back(ReadRigPhoto(element, std::filesystem::path(path).parent_path()));
    }
    return photos;
  });
}

}  // namespace cairn
