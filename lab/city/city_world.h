// A map of a simulated city and queries against it: what experiments run on.
#ifndef CAIRN_LAB_CITY_CITY_WORLD_H_
#define CAIRN_LAB_CITY_CITY_WORLD_H_

#include <functional>
#include <string>
#include <vector>

#include "eval/eval_query.h"
#include "ingest/ingest_session.h"
#include "lab/city/cameras/mapping_options.h"
#include "lab/city/cameras/phone_queries.h"
#include "lab/city/geometry/city_options.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

struct CityWorldOptions {
  CityOptions city;
  MappingOptions mapping;
  PhoneQueryOptions queries;
  DescriptorModelOptions descriptors;
  IngestOptions ingest;  // session_name is set per tile.
  int num_threads = 2;   // The result does not depend on it.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// How much of a city.
enum class CityWorldSize {
  kQuick,   // 100 m square: about a second. Too small to judge accuracy on, large enough to run.
  kMedium,  // 300 m square, four to nine tiles.
  kPaper,   // One tile of 150 m as the paper has it: 1,000 to 2,000 panoramas.
};
// "quick", "medium", "paper".
const char* CityWorldSizeName(CityWorldSize size);
// Throws Error(kInvalidArgument) that lists the names.
CityWorldSize CityWorldSizeFromName(const std::string& name);

// A city of the given character at the place of CityPreset, mapped and queried.
CityWorldOptions CityWorldPreset(CityCharacter character, CityWorldSize size);

// Writes a map to `map_path` (must not exist) and returns the queries with their true poses. Each
// tile is mapped and ingested as a session of its own ("tile 32T-...") from the center outwards, so
// that memory holds one tile at a time and no tile is written twice but for the few keyframes whose
// reconstructed place is across a border; the first tile trains the codebook. `progress` (may be
// empty) gets tiles done and total. Deterministic.
std::vector<EvalQuery> BuildCityWorld(const CityWorldOptions& options, const std::string& map_path,
                                      const std::function<void(int done, int total)>& progress);
// Same, with queries at the places given.
std::vector<EvalQuery> BuildCityWorld(const CityWorldOptions& options,
                                      const std::vector<PhonePlace>& places,
                                      const std::string& map_path,
                                      const std::function<void(int done, int total)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CITY_WORLD_H_
