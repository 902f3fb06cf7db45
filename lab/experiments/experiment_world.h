// The worlds that experiments measure in: a map and queries with true poses, built once a run.
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
#include "lab/city/city_world.h"
#include "lab/city/geometry/city_options.h"
#include "storage/map/map_store.h"

namespace cairn {

struct ExperimentWorldOptions {
  CityCharacter character = CityCharacter::kGrid;
  CityWorldSize size = CityWorldSize::kQuick;
  int num_queries = 20;
  // Queries of half as many keypoints, of which 6 % have a landmark instead of 10 %: some 30 of
  // 500. The presets' queries are answered too well to tell one method from another by.
  bool hard_queries = false;
  IngestOptions ingest;
  // Tells worlds apart that differ in `ingest`; letters, digits, '_' and '-'.
  std::string ingest_name;
  uint64_t seed = 1;

  // Names the world: equal keys, equal worlds. For people and file names.
  std::string Key() const;
};

struct ExperimentWorld {
  std::string description;
  std::shared_ptr<const MapStore> store;
  MapInfo info;
  std::vector<EvalQuery> queries;
};

// Builds worlds on demand, in a folder, and keeps them for the experiments that come after. One
// thread.
class ExperimentWorlds {
 public:
  // Maps are written to `folder`, which is made.
  explicit ExperimentWorlds(std::string folder);

  // `progress` (may be empty) gets a phase, steps done and total.
  std::shared_ptr<const ExperimentWorld> Get(
      const ExperimentWorldOptions& options,
      const std::function<void(const std::string&, int, int)>& progress);

  // A file of that name in the folder, for maps that experiments keep themselves.
  std::string MapPath(const std::string& name) const;

  // Removes a world's map, so that it does not fill the disk. Those who hold it keep it open.
  void Forget(const ExperimentWorldOptions& options);

 private:
  std::string folder_;
  std::map<std::string, std::shared_ptr<const ExperimentWorld>> worlds_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_EXPERIMENT_WORLD_H_
