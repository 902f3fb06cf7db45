// Prints the comparison of filter and bundle adjustment (paper, table and figure of "Evaluation of
// the Pose Fusion"). The recordings are a simulated walk, and real trajectories and inertial
// samples of the test data under simulated cameras.
//
//   cairn_fusion_comparison [seconds per recording] [seed] [timed runs]
#include <cstdio>
#include <cstdlib>

#include "eval/recordings/room_recordings.h"
#include "lab/rivals/fusion/comparison.h"
#include "lab/trajectories.h"
#include "support/test_data.h"

namespace cairn::fusion {
namespace {

void Compare(const Trajectory& trajectory, RecordingOptions options, double duration_s,
             uint64_t seed, int num_timings) {
  options.duration_s = duration_s;
  options.seed = seed;
  const Recording recording = SimulateRecording(trajectory, options);
  ComparisonOptions comparison;
  comparison.num_timings = num_timings;
  comparison.steadies_rivals = true;
  comparison.variants.push_back({10, 10, DiscardPolicy::kDiscard, true});
  comparison.variants.push_back({10, 5, DiscardPolicy::kMarginalize, true});
  std::puts(ComparisonTable(trajectory.name, CompareEstimators(recording, comparison)).c_str());
  std::fflush(stdout);
}

void Run(double duration_s, uint64_t seed, int num_timings) {
  Compare(testing::WalkTrajectory(duration_s, seed), testing::WalkRecordingOptions(seed),
          duration_s, seed, num_timings);
  const std::filesystem::path data = cairn::testing::TestDataDir();
  if (!std::filesystem::exists(data)) {
    std::printf("no real trajectories: %s is not there (set CAIRN_TEST_DATA)\n", data.c_str());
    return;
  }
  for (const Room& room : AllRooms(data)) {
    Compare(room.trajectory, room.options, duration_s, seed, num_timings);
  }
}

}  // namespace
}  // namespace cairn::fusion

int main(int argc, char** argv) {
  cairn::fusion::Run(argc > 1 ? std::atof(argv[1]) : 60.0, argc > 2 ? std::atoi(argv[2]) : 1,
                     argc > 3 ? std::atoi(argv[3]) : 1);
}
