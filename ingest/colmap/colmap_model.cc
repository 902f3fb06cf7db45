#include "ingest/colmap/colmap_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "core/error.h"
#include "core/logging.h"
#include "core/printable.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

// A project has its models in sparse/0, sparse/1, ...
constexpr int kMaxDepth = 2;
constexpr size_t kMaxListedModels = 10;

bool HasModel(const fs::path& dir, const char* extension) {
  std::error_code ignored;
  for (const char* stem : {"cameras", "images", "points3D"}) {
    if (!fs::is_regular_file(dir / (std::string(stem) + extension), ignored)) {
      return false;
    }
  }
  return true;
}

bool HasModel(const fs::path& dir) { return HasModel(dir, ".bin") || HasModel(dir, ".txt"); }

void CollectModelsBelow(const fs::path& dir, int depth, std::vector<fs::path>* models) {
  std::error_code error;
  for (fs::directory_iterator it(dir, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (!it->is_directory(ignored)) {
      continue;
    }
    if (HasModel(it->path())) {
      models->push_back(it->path());
    } else if (depth < kMaxDepth) {
      CollectModelsBelow(it->path(), depth + 1, models);
    }
  }
}

std::string NumImagesText(const std::string& model_dir) {
  try {
    const uint64_t num_images = HasModel(model_dir, ".bin") ? CountImagesOfBinaryModel(model_dir)
                                                            : CountImagesOfTextModel(model_dir);
    return fmt::format("{} image{}", num_images, num_images == 1 ? "" : "s");
  } catch (const Error&) {
    return "damaged";
  }
}

[[noreturn]] void RefuseChoice(const std::string& dir, const std::vector<fs::path>& models) {
  std::string list;
  for (size_t i = 0; i < std::min(models.size(), kMaxListedModels); ++i) {
    list += fmt::format("{} {} ({})", i == 0 ? "" : ",", Excerpt(models[i].string(), 1000),
                        NumImagesText(models[i].string()));
  }
  if (models.size() > kMaxListedModels) {
    list += fmt::format(" and {} others", models.size() - kMaxListedModels);
  }
  throw Error(ErrorCode::kBadInput,
              fmt::format("{}: there are {} COLMAP models below this folder; name one of them:{}",
                          dir, models.size(), list));
}

}  // namespace

std::string FindColmapModel(const std::string& dir) {
  std::error_code ignored;
  if (fs::is_regular_file(dir, ignored)) {
    const fs::path folder = fs::absolute(dir).parent_path();
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: this is a file; name the folder of the COLMAP model{}", dir,
                            HasModel(folder) ? ", " + folder.string() : ""));
  }
  if (!fs::is_directory(dir, ignored)) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("{}: no such folder; expected that of a COLMAP model", dir));
  }
  if (HasModel(dir)) {
    return dir;
  }
  std::vector<fs::path> models;
  CollectModelsBelow(dir, 1, &models);
  std::sort(models.begin(), models.end());
  if (models.empty()) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("{}: no COLMAP model here; expected cameras, images and points3D, all "
                            ".bin or all .txt",
                            dir));
  }
  if (models.size() > 1) {
    RefuseChoice(dir, models);
  }
  LogInfo("{}: the COLMAP model is in {}", dir, models.front().string());
  return models.front().string();
}

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
