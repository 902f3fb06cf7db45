#include "ingest/readers/colmap_model.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/error.h"

namespace cairn {
namespace {

bool HasModel(const std::string& model_dir, const char* extension) {
  const std::filesystem::path dir(model_dir);
  std::error_code ignored;
  for (const char* stem : {"cameras", "images", "points3D"}) {
    if (!std::filesystem::is_regular_file(dir / (std::string(stem) + extension), ignored)) {
      return false;
    }
  }
  return true;
}

}  // namespace

ColmapModel ReadColmapModel(const std::string& model_dir) {
  if (HasModel(model_dir, ".bin")) {
    return ReadBinaryColmapModel(model_dir);
  }
  if (HasModel(model_dir, ".txt")) {
    return ReadTextColmapModel(model_dir);
  }
  throw Error(
      ErrorCode::kNotFound,
      fmt::format("{}: no COLMAP model here; expected cameras, images and points3D, all .bin "
                  "or all .txt",
                  model_dir));
}

}  // namespace cairn
