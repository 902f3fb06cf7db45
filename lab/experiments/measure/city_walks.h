// Walks through a simulated city as a client's estimators get them: inertial samples, tracks, and
// the answers of this engine; private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_CITY_WALKS_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_CITY_WALKS_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lab/city/city_world.h"
#include "lab/city/geometry/city_options.h"
#include "lab/recordings/recording.h"

namespace cairn {

struct CityWalksOptions {
  CityCharacter character = CityCharacter::kGrid;
  CityWorldSize size = CityWorldSize::kQuick;
  int num_walks = 1;
  double duration_s = 30.0;      // Of each.
  double first_counted_s = 5.0;  // See Recording::first_counted_frame.
  int frames_per_query = 5;      // At ten frames a second.
  uint64_t seed = 1;
  int num_threads = 2;
};

// Maps the city into `map_path`, which must not exist, and asks about every n-th frame of each
// walk, one phone query each (PhoneQueries), with the localizer's defaults. `global` is
// east-north-up at the beginning of the walk. The matches are of keypoints of their own, not of the
// tracks. `progress` as BuildCityWorld. Deterministic.
std::vector<fusion::Recording> RecordCityWalks(
    const CityWalksOptions& options, const std::string& map_path,
    const std::function<void(int done, int total)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_CITY_WALKS_H_
