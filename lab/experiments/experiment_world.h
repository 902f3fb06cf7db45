// The worlds of the experiments: a map, and queries with true poses. Each world is built once per
// run.
#ifndef CAIRN_LAB_EXPERIMENTS_EXPERIMENT_WORLD_H_
#define CAIRN_LAB_EXPERIMENTS_EXPERIMENT_WORLD_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "eval/eval_query.h"
#include "ingest/ingest_session.h"
#include "lab/city/city_options.h"
#include "lab/city/city_world.h"
#include "storage/map/map_store.h"

namespace cairn {

struct ExperimentWorldOptions {
  CityCharacter character = CityCharacter::kGrid;
  CityWorldSize size = CityWorldSize::kQuick;
  int num_queries = 20;
  // Queries with half as many keypoints, of which 6 % instead of 10 % have a landmark: about 30 of
  // 500. The engine answers the presets' queries too well for comparisons between methods.
  bool hard_queries = false;
  IngestOptions ingest;
  // Distinguishes worlds with different `ingest`. Letters, digits, '_' and '-'.
  std::string ingest_name;
  uint64_t seed = 1;

  // Names the world for people and in file names. Worlds with equal keys are equal.
  std::string Key() const;
};

struct ExperimentWorld {
  std::string description;
  std::shared_ptr<const MapStore> store;
  MapInfo info;
  std::vector<EvalQuery> queries;
};

// Builds worlds on demand in a folder and keeps them for later experiments. Use from one thread.
class ExperimentWorlds {
 public:
  // Creates `folder`, which receives the maps.
  explicit ExperimentWorlds(std::string folder);

  // `progress` (may be empty) receives a phase, the steps done and the total.
  std::shared_ptr<const ExperimentWorld> Get(
      const ExperimentWorldOptions& options,
      const std::function<void(const std::string&, int, int)>& progress);

  // Returns the path of a file in the folder, for maps that an experiment manages itself.
  std::string MapPath(const std::string& name) const;

  // Removes a world's map to free disk space. Holders of the world keep its map open.
  void Forget(const ExperimentWorldOptions& options);

 private:
  std::string folder_;
  std::map<std::string, std::shared_ptr<const ExperimentWorld>> worlds_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_EXPERIMENT_WORLD_H_
