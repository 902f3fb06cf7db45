// Builds a map of a simulated city and queries against it. Experiments run on these worlds.
#ifndef CAIRN_LAB_CITY_CITY_WORLD_H_
#define CAIRN_LAB_CITY_CITY_WORLD_H_

#include <functional>
#include <string>
#include <vector>

#include "eval/eval_query.h"
#include "ingest/ingest_session.h"
#include "lab/city/city_options.h"
#include "lab/city/mapping_options.h"
#include "lab/city/phone_queries.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

struct CityWorldOptions {
  CityOptions city;
  SimulatedMappingOptions mapping;
  PhoneQueryOptions queries;
  DescriptorModelOptions descriptors;
  IngestOptions ingest;  // session_name is set for each tile.
  int num_threads = 2;   // The result does not depend on it.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Size of the mapped part of a city.
enum class CityWorldSize {
  kQuick,   // 100 m square, about a second: enough to run, too small to judge accuracy.
  kMedium,  // 300 m square, four to nine tiles.
  kPaper,   // One 150 m tile as in the paper: 1,000 to 2,000 panoramas.
};
// "quick", "medium", "paper".
const char* CityWorldSizeName(CityWorldSize size);
// Throws Error(kInvalidArgument) that lists the names.
CityWorldSize CityWorldSizeFromName(const std::string& name);

// Options for a city of the given character at the place that CityPreset chooses.
CityWorldOptions CityWorldPreset(CityCharacter character, CityWorldSize size);

// Writes a map to `map_path` (which must not exist) and returns the queries with their true poses.
//
// Each tile is mapped and ingested as its own session ("tile 32T-..."), from the center outward.
// Memory therefore holds one tile at a time. No tile is written twice, except for the few keyframes
// whose reconstructed position is across a border. The first tile trains the codebook.
//
// `progress` (may be empty) receives the number of finished tiles and the total. Deterministic.
std::vector<EvalQuery> BuildCityWorld(const CityWorldOptions& options, const std::string& map_path,
                                      const std::function<void(int done, int total)>& progress);
// Same as above, with queries at the given places.
std::vector<EvalQuery> BuildCityWorld(const CityWorldOptions& options,
                                      const std::vector<PhonePlace>& places,
                                      const std::string& map_path,
                                      const std::function<void(int done, int total)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CITY_WORLD_H_
