// Runs Monte Carlo simulations of the estimator to check that its covariance matches its errors.
//
//   cairn_fusion_consistency [num_runs] [duration_s] [scenario or all] [first_seed]
//
// Prints the share of steps at which the mean normalized error squared is within the 95 % bounds of
// that many runs, for the local pose (6 degrees of freedom) and global_from_local (4).
// at which the mean normalized error squared lies within the 95 % bounds of that many runs.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <vector>

#include "core/angles.h"
#include "fusion/errors.h"
#include "fusion/estimator/estimator.h"
#include "fusion/filter/chi_square.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

struct Scenario {
  const char* name;
  bool with_map;
  double map_sigma_m;
  double tile_sigma_m;
  bool considers_tiles;
};

struct Step {
  double pose = 0.0, position = 0.0, rotation = 0.0, global = 0.0;
  int num_global = 0;
};

struct RunErrors {
  Rms position_m, rotation_rad;
};

RunErrors RunOnce(const Scenario& scenario, uint64_t seed, double duration_s,
                  std::vector<Step>* steps) {
  SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = duration_s;
  options.map_sigma_m = scenario.map_sigma_m;
  options.tile_sigma_m = scenario.tile_sigma_m;
  const Simulation simulation(options);
  FusionOptions fusion = simulation.MatchingFusionOptions();
  if (!scenario.considers_tiles) {
    fusion.state.tile_sigma_m = 0.0;
  }
  Estimator estimator(fusion);
  const Rigid3d local_from_world = simulation.LocalFromWorld(0);
  RunErrors errors;
  steps->resize(simulation.frames().size());
  Replay(simulation, 0, &estimator, [&](size_t i) {
    const FilterState& state = *estimator.state();
    const auto error = ImuError(state.imu(), simulation.frames()[i].truth, local_from_world);
    errors.position_m.Add(error.segment<3>(3).norm());
    errors.rotation_rad.Add(error.head<3>().norm());
    if (i > 5) {
      Step& step = (*steps)[i];
      step.pose += Nees(error.head<6>(), state.covariance().topLeftCorner<6, 6>());
      step.position += Nees(error.segment<3>(3), state.covariance().block<3, 3>(3, 3));
      step.rotation += Nees(error.head<3>(), state.covariance().topLeftCorner<3, 3>());
      if (state.global_from_local()) {
        step.global += Nees(GlobalError(*state.global_from_local(), local_from_world),
                            state.covariance().block<4, 4>(kGlobalIdx, kGlobalIdx));
        ++step.num_global;
      }
    }
    if (scenario.with_map) {
      if (const auto query = estimator.PollQuery()) {
        estimator.Submit(simulation.MakeAnswer(*query, i, {}));
      }
    }
  });
  return errors;
}

void RunScenario(const Scenario& scenario, int num_runs, double duration_s, uint64_t first_seed) {
  std::vector<Step> steps;
  Rms position_m, rotation_rad;
  const std::clock_t begin = std::clock();
  for (int run = 0; run < num_runs; ++run) {
    const RunErrors errors =
        RunOnce(scenario, first_seed + static_cast<uint64_t>(run), duration_s, &steps);
    position_m.Add(errors.position_m.Value());
    rotation_rad.Add(errors.rotation_rad.Value());
  }
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const auto bounds = [num_runs](int dof) {
    const double n = num_runs * dof;
    return std::pair{ChiSquareQuantile(num_runs * dof, -1.96) / n,
                     ChiSquareQuantile(num_runs * dof, 1.96) / n};
  };
  const auto share = [&](int dof, const auto& value, const auto& count) {
    const auto [low, high] = bounds(dof);
    int within = 0, total = 0;
    double sum = 0.0;
    for (size_t i = 6; i < steps.size(); ++i) {
      if (count(steps[i]) == num_runs) {
        const double mean = value(steps[i]) / num_runs;
        within += mean > low && mean < high;
        sum += mean;
        ++total;
      }
    }
    std::printf("  %5.3f (%3.0f %% in [%.3f, %.3f])", sum / std::max(total, 1),
                100.0 * within / std::max(total, 1), low, high);
  };
  const auto all = [num_runs](const Step&) { return num_runs; };
  std::printf("%-10s rmse %.3f m %.2f deg, %.1f s CPU\n   nees pose", scenario.name,
              position_m.Value(), rotation_rad.Value() * kDegPerRad, cpu_s);
  share(
      6, [](const Step& step) { return step.pose; }, all);
  std::printf("\n   position");
  share(
      3, [](const Step& step) { return step.position; }, all);
  std::printf("  rotation");
  share(
      3, [](const Step& step) { return step.rotation; }, all);
  if (scenario.with_map) {
    std::printf("\n   global  ");
    share(
        4, [](const Step& step) { return step.global; },
        [](const Step& step) { return step.num_global; });
  }
  std::printf("\n");
}

}  // namespace
}  // namespace cairn::fusion::testing

int main(int argc, char** argv) {
  using cairn::fusion::testing::Scenario;
  const int num_runs = argc > 1 ? std::atoi(argv[1]) : 50;
  const double duration_s = argc > 2 ? std::atof(argv[2]) : 60.0;
  const std::string_view wanted = argc > 3 ? argv[3] : "all";
  const uint64_t first_seed = argc > 4 ? std::strtoull(argv[4], nullptr, 10) : 1;
  const Scenario scenarios[] = {{"local", false, 0.0, 0.0, false},
                                {"perfect", true, 0.0, 0.0, false},
                                {"noisy", true, 0.05, 0.0, false},
                                {"schmidt", true, 0.03, 0.1, true},
                                {"inflation", true, 0.03, 0.1, false}};
  for (const Scenario& scenario : scenarios) {
    if (wanted == "all" || wanted == scenario.name) {
      cairn::fusion::testing::RunScenario(scenario, num_runs, duration_s, first_seed);
    }
  }
  return 0;
}
