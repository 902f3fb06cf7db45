// Prints the comparison of filter and bundle adjustment on simulated walks.
#include <cstdio>
#include <cstdlib>

#include "fusion/rival/comparison.h"
#include "fusion/rival/simulated_recording.h"

namespace cairn::fusion {
namespace {

void Run(double duration_s, uint64_t seed) {
  testing::SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = duration_s;
  options.num_features = 300;
  options.landmarks_per_metre = 80;
  options.map_sigma_m = 0.05;
  const testing::Simulation simulation(options);
  const Recording recording = testing::MakeRecording(simulation, {});
  ComparisonOptions comparison;
  comparison.num_timings = 1;
  comparison.variants.push_back({10, 10, DiscardPolicy::kDiscard, true});
  comparison.variants.push_back({5, 2, DiscardPolicy::kDiscard, true});
  comparison.variants.push_back({10, 5, DiscardPolicy::kMarginalize, true});
  std::fputs(ComparisonTable("simulated walk", CompareEstimators(recording, comparison)).c_str(),
             stdout);
}

}  // namespace
}  // namespace cairn::fusion

int main(int argc, char** argv) {
  cairn::fusion::Run(argc > 1 ? std::atof(argv[1]) : 60.0, argc > 2 ? std::atoi(argv[2]) : 1);
}
