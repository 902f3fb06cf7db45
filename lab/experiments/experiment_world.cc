#include "lab/experiments/experiment_world.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "lab/city/city_world.h"

namespace cairn {
namespace {

constexpr int kHardKeypoints = 500;
constexpr double kHardMappedFraction = 0.06;

CityWorldOptions CityOptionsOf(const ExperimentWorldOptions& options) {
  CityWorldOptions city = CityWorldPreset(options.character, options.size);
  city.queries.num_queries = options.num_queries;
  if (options.hard_queries) {
    city.queries.num_keypoints = kHardKeypoints;
    city.queries.mapped_fraction = kHardMappedFraction;
  }
  city.ingest = options.ingest;
  city.city.seed = city.mapping.seed = city.queries.seed = city.descriptors.seed = options.seed;
  city.ingest.codebook.seed = options.seed;
  return city;
}

}  // namespace

std::string ExperimentWorldOptions::Key() const {
  return fmt::format("{}_{}_q{}{}_s{}{}{}", CityCharacterName(character), CityWorldSizeName(size),
                     num_queries, hard_queries ? "hard" : "", seed, ingest_name.empty() ? "" : "_",
                     ingest_name);
}

ExperimentWorlds::ExperimentWorlds(std::string folder) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
}

std::shared_ptr<const ExperimentWorld> ExperimentWorlds::Get(
    const ExperimentWorldOptions& options,
    const std::function<void(const std::string&, int, int)>& progress) {
  const std::string key = options.Key();
  if (const auto found = worlds_.find(key); found != worlds_.end()) {
    return found->second;
  }
  const std::string path = MapPath(key);
  std::filesystem::remove(path);
  auto world = std::make_shared<ExperimentWorld>();
  world->description = key;
  world->queries = BuildCityWorld(CityOptionsOf(options), path, [&](int done, int total) {
    if (progress) {
      progress("building " + key, done, total);
    }
  });
  world->store = std::make_shared<const MapStore>(MapStore::Open(path, OpenMode::kReadOnly));
  world->info = world->store->Snapshot().Info();
  return worlds_[key] = std::move(world);
}

void ExperimentWorlds::Forget(const ExperimentWorldOptions& options) {
  const std::string key = options.Key();
  worlds_.erase(key);
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    std::filesystem::remove(MapPath(key) + suffix, ignored);
  }
}

std::string ExperimentWorlds::MapPath(const std::string& name) const {
  return (std::filesystem::path(folder_) / (name + ".gpkg")).string();
}

}  // namespace cairn
