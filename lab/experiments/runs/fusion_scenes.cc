#include "lab/experiments/runs/fusion_scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <span>
#include <utility>

#include "core/angles.h"
#include "eval/recordings/room_recordings.h"
#include "lab/experiments/measure/city_walks.h"

namespace cairn {
namespace {

constexpr CityCharacter kCharacter = CityCharacter::kGrid;

double Or(double value, const fusion::MethodResult& result) {
  return result.num_counted_frames > 0 ? value : std::numeric_limits<double>::quiet_NaN();
}

double MeanAt(const FusionScene& scene, std::span<const size_t> recordings,
              const std::function<double(const std::vector<fusion::MethodResult>&)>& of) {
  double sum = 0.0;
  for (const size_t recording : recordings) {
    sum += of(scene.results[recording]);
  }
  return sum / static_cast<double>(recordings.size());
}

CityWalksOptions WalksOptions(const ExperimentContext& context) {
  CityWalksOptions options;
  options.character = kCharacter;
  options.size = context.Pick(CityWorldSize::kQuick, CityWorldSize::kMedium);
  options.num_walks = context.Pick(2, 8);
  options.duration_s = context.Pick(12.0, 60.0);
  options.seed = context.seed;
  options.num_threads = context.num_threads;
  return options;
}

std::vector<fusion::Recording> CityRecordings(const ExperimentContext& context) {
  const std::string path = context.worlds->MapPath("walks");
  std::filesystem::remove(path);
  return RecordCityWalks(WalksOptions(context), path, [&](int done, int total) {
    if (context.progress) {
      context.progress("building the walks", done, total);
    }
  });
}

// Records one trajectory with cameras, landmarks and noise of several seeds.
std::vector<fusion::Recording> RoomRecordings(const fusion::Room& room,
                                              const ExperimentContext& context) {
  fusion::RecordingOptions options = room.options;
  options.duration_s = context.Pick(12.0, 60.0);
  std::vector<fusion::Recording> recordings;
  for (int i = 0; i < context.Pick(2, 4); ++i) {
    options.seed = context.seed + static_cast<uint64_t>(i);
    recordings.push_back(fusion::SimulateRecording(room.trajectory, options));
  }
  return recordings;
}

FusionScene RunScene(const std::string& name, const std::vector<fusion::Recording>& recordings,
                     fusion::ComparisonOptions options, const ExperimentContext& context) {
  options.num_timings = context.Pick(1, 2);
  FusionScene scene;
  scene.name = name;
  for (const fusion::Recording& recording : recordings) {
    scene.results.push_back(fusion::CompareEstimators(recording, options));
    if (context.progress) {
      context.progress("comparing on " + name, static_cast<int>(scene.results.size()),
                       static_cast<int>(recordings.size()));
    }
  }
  for (const fusion::MethodResult& result : scene.results.front()) {
    scene.methods.push_back(result.name);
    scene.is_steady.push_back(result.is_steady);
  }
  return scene;
}

}  // namespace

std::vector<FusionScene> RunFusionScenes(const ExperimentContext& context,
                                         const std::vector<fusion::RivalVariant>& variants,
                                         bool steadies_rivals) {
  fusion::ComparisonOptions comparison;
  comparison.variants = variants;
  comparison.steadies_rivals = steadies_rivals;
  // Reads the rooms first, because the walks take minutes and the folder may be wrong.
  const std::vector<fusion::Room> rooms = context.trajectories_folder.empty()
                                              ? std::vector<fusion::Room>()
                                              : fusion::AllRooms(context.trajectories_folder);
  std::vector<FusionScene> scenes;
  const std::string city = fmt::format("{} city", CityCharacterName(kCharacter));
  scenes.push_back(RunScene(city, CityRecordings(context), comparison, context));
  for (const fusion::Room& room : rooms) {
    scenes.push_back(
        RunScene(room.trajectory.name, RoomRecordings(room, context), comparison, context));
  }
  return scenes;
}

ExperimentParameters FusionParameters(const ExperimentContext& context) {
  const CityWalksOptions walks = WalksOptions(context);
  return {
      {"walks", fmt::format("{} of {:.0f} s in the {} city ({}), asked about twice a second",
                            walks.num_walks, walks.duration_s, CityCharacterName(walks.character),
                            CityWorldSizeName(walks.size))},
      {"real trajectories", context.trajectories_folder.empty() ? "none" : "with --trajectories"}};
}

double PositionRmseM(const fusion::MethodResult& result) {
  return Or(result.position_rmse_m, result);
}

double RotationRmseDeg(const fusion::MethodResult& result) {
  return Or(kDegPerRad * result.rotation_rmse_rad, result);
}

Interval MeanOver(const FusionScene& scene, size_t method, const FusionMeasure& measure) {
  return Bootstrap(scene.results.size(), [&](std::span<const size_t> recordings) {
    return MeanAt(scene, recordings, [&](const auto& results) { return measure(results[method]); });
  });
}

Interval RatioOver(const FusionScene& scene, size_t method, size_t other,
                   const FusionMeasure& measure) {
  return Bootstrap(scene.results.size(), [&](std::span<const size_t> recordings) {
    const auto mean = [&](size_t at) {
      return MeanAt(scene, recordings, [&](const auto& results) { return measure(results[at]); });
    };
    const double divisor = mean(other);
    return divisor > 0.0 ? mean(method) / divisor : std::numeric_limits<double>::quiet_NaN();
  });
}

size_t BestRival(const FusionScene& scene, const FusionMeasure& measure, bool is_steady) {
  size_t best = kSteadyFilter + 1;
  while (scene.is_steady[best] != is_steady) {
    ++best;
  }
  for (size_t method = best + 1; method < scene.methods.size(); ++method) {
    if (scene.is_steady[method] == is_steady &&
        MeanOver(scene, method, measure).value < MeanOver(scene, best, measure).value) {
      best = method;
    }
  }
  return best;
}

Verdict JudgeScenes(const std::vector<FusionScene>& scenes,
                    const std::function<Verdict(const FusionScene&, std::string*)>& judge,
                    std::string* sentence) {
  std::vector<Verdict> verdicts;
  for (const FusionScene& scene : scenes) {
    verdicts.push_back(judge(scene, sentence));
  }
  return JudgeAll(verdicts);
}

Figure SceneFigure(const std::string& name, const std::string& title, const std::string& y_label,
                   const std::vector<FusionScene>& scenes, const FusionMeasure& measure) {
  Figure figure{name, title, "method", y_label};
  figure.log_y = true;
  std::vector<size_t> methods;
  for (size_t method = 0; method < scenes.front().methods.size(); ++method) {
    if (method <= kSteadyFilter || !scenes.front().is_steady[method]) {
      methods.push_back(method);
      figure.x_names.push_back(scenes.front().methods[method]);
    }
  }
  for (const FusionScene& scene : scenes) {
    FigureSeries series{scene.name, {}};
    for (const size_t method : methods) {
      series.points.push_back(
          {static_cast<double>(series.points.size()), MeanOver(scene, method, measure)});
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

}  // namespace cairn
