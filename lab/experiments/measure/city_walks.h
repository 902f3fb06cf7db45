// Walks through a simulated city in the form that a client's estimators receive: inertial samples,
// tracks, and this engine's answers. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_CITY_WALKS_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_CITY_WALKS_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "eval/recordings/recording.h"
#include "lab/city/city_options.h"
#include "lab/city/city_world.h"

namespace cairn {

struct CityWalksOptions {
  CityCharacter character = CityCharacter::kGrid;
  CityWorldSize size = CityWorldSize::kQuick;
  int num_walks = 1;
  double duration_s = 30.0;      // Length of each walk.
  double first_counted_s = 5.0;  // See Recording::first_counted_frame.
  int frames_per_query = 5;      // At ten frames per second.
  uint64_t seed = 1;
  int num_threads = 2;
};

// Maps the city into `map_path`, which must not exist. Queries every n-th frame of each walk with
// one phone query (PhoneQueries) and the localizer's defaults. `global` is east-north-up at the
// beginning of the walk. Matches belong to keypoints of their own, not to tracks. `progress` is
// used as in BuildCityWorld. Deterministic.
std::vector<fusion::Recording> RecordCityWalks(
    const CityWalksOptions& options, const std::string& map_path,
    const std::function<void(int done, int total)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_CITY_WALKS_H_
