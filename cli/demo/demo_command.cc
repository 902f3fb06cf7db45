// `cairn demo`: runs the whole pipeline on a rendered street and localizes photos over HTTP.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/demo/demo_world.h"
#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/angles.h"
#include "core/error.h"
#include "core/images/gray_image.h"
#include "core/logging.h"
#include "core/seconds_since.h"
#include "eval/evaluation.h"
#include "eval/pictures/pictures.h"
#include "http/client.h"
#include "http/server.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

// The demo succeeds if at least this share of the answers is within these errors.
constexpr double kMinShareRight = 0.8;
constexpr double kMaxPositionErrorM = 0.5;
constexpr double kMaxRotationErrorDeg = 2.0;

struct DemoArguments {
  std::string output_dir = "demo-output";
  bool quick = false;
  uint64_t seed = 1;
  bool json = false;
};

// Answers over HTTP and the round-trip times measured by the client.
struct Answers {
  EvalReport report;
  std::vector<double> round_trip_seconds;  // Parallel to report.answers.
};

template <typename Ask>
Answers AskAll(const char* phase, const std::vector<EvalQuery>& queries, Progress* progress,
               const Ask& ask) {
  Answers answers;
  answers.report = Evaluate(
      queries,
      [&](const EvalQuery& query) {
        const auto start = std::chrono::steady_clock::now();
        LocalizeResult result = ask(query);
        answers.round_trip_seconds.push_back(SecondsSince(start));
        return result;
      },
      [&](int done, int total) { progress->Update(phase, done, total); });
  return answers;
}

bool IsRight(const EvalAnswer& answer) {
  return answer.position_error_m <= kMaxPositionErrorM &&
         answer.rotation_error_rad * kDegPerRad <= kMaxRotationErrorDeg;
}

int CountRight(const EvalReport& report) {
  return static_cast<int>(std::count_if(report.answers.begin(), report.answers.end(), IsRight));
}

void PrintTable(const Answers& answers) {
  fmt::print("{:<16} {:>8} {:>8} {:>8} {:>11}", "photo", "error m", "deg", "inliers", "round trip");
  for (int stage = 0; stage < kNumStages; ++stage) {
    fmt::print(" {:>10}", StageName(static_cast<Stage>(stage)));
  }
  fmt::print("\n");
  for (size_t i = 0; i < answers.report.answers.size(); ++i) {
    const EvalAnswer& answer = answers.report.answers[i];
    if (answer.result.localized) {
      fmt::print("{:<16} {:>8.3f} {:>8.3f} {:>8}", answer.name, answer.position_error_m,
                 answer.rotation_error_rad * kDegPerRad, answer.result.matches.size());
    } else {
      fmt::print("{:<16} {:<26}", answer.name, NotLocalizedReasonName(answer.result.reason));
    }
    fmt::print(" {:>8.1f} ms", 1e3 * answers.round_trip_seconds[i]);
    for (const double seconds : answer.result.times.seconds) {
      fmt::print(" {:>7.2f} ms", 1e3 * seconds);
    }
    fmt::print("\n");
  }
}

void PrintSummary(const char* sent, const EvalReport& report) {
  fmt::print("{:<14} {} of {} within {} m and {} deg; median error {:.3f} m, {:.3f} deg\n", sent,
             CountRight(report), report.num_queries, kMaxPositionErrorM, kMaxRotationErrorDeg,
             report.median_position_error_m.value,
             report.median_rotation_error_rad.value * kDegPerRad);
}

nlohmann::ordered_json SummaryJson(const EvalReport& report) {
  return {{"queries", report.num_queries},
          {"right", CountRight(report)},
          {"medianPositionErrorM", report.median_position_error_m.value},
          {"medianRotationErrorDeg", report.median_rotation_error_rad.value * kDegPerRad}};
}

void PrintDemoJson(const DemoWorld& world, const EvalReport& from_images,
                   const EvalReport& from_features) {
  PrintJson({{"map", world.map_path},
             {"photos", world.num_mapping_photos},
             {"photosInMap", world.num_mapped},
             {"landmarks", world.ingest.num_landmarks_written},
             {"sentImages", SummaryJson(from_images)},
             {"sentFeatures", SummaryJson(from_features)}});
}

void DrawPictures(const DemoWorld& world, const EvalReport& report,
                  const std::filesystem::path& output_dir) {
  std::vector<TopViewPose> poses;
  for (size_t i = 0; i < world.queries.size(); ++i) {
    const EvalQuery& query = world.queries[i];
    const LocalizeResult& result = report.answers[i].result;
    DrawMatches((output_dir / fmt::format("matches_{:02}.png", i)).string(), world.photos[i],
                query.query, result);
    TopViewPose pose;
    pose.label = fmt::format("{}", i);
    pose.prior = query.query.prior->position;
    pose.prior_accuracy_m = query.query.prior->accuracy_m;
    pose.reference_cam_from_ecef = query.cam_from_ecef;
    if (result.localized) {
      pose.estimated_cam_from_ecef = result.cam_from_ecef;
    }
    poses.push_back(std::move(pose));
  }
  DrawTopView((output_dir / "top_view.png").string(),
              MapStore::Open(world.map_path, OpenMode::kReadOnly), poses);
}

void PrintWorld(const DemoWorld& world) {
  fmt::print(
      "Mapped a rendered street by `cairn map`: {} of {} photos in the map, {} landmarks,\n"
      "{} descriptors, {} tiles, {:.0f} kB. The map stands where the GPS of the photos says, "
      "whose\n"
      "noise is {} m per axis: {:.2f} m from the true place, turned by {:.2f} degrees, {:.4f} "
      "times\n"
      "as large. The errors below are those within the map.\n"
      "Queried a local server with {} other photos; noise of the priors: 10 m per axis for the\n"
      "position, 1 degree for gravity.\n\n",
      world.num_mapped, world.num_mapping_photos, world.ingest.num_landmarks_written,
      world.ingest.num_descriptors_written, world.ingest.num_tiles_written,
      1e-3 * static_cast<double>(world.ingest.num_payload_bytes), world.gps_sigma_m,
      world.map_from_earth.moved_m, world.map_from_earth.turned_rad * kDegPerRad,
      world.map_from_earth.scale, world.queries.size());
}

// The program as any folder can call it: the demo's script does not run where its caller stands.
std::string ProgramName(const std::string& path) {
  return path.find('/') == std::string::npos
             ? path
             : std::filesystem::absolute(path).lexically_normal().string();
}

// Quotes a word for the shell if it has to be.
std::string ShellWord(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+:@%";
  if (word.find_first_not_of(kPlain) == std::string::npos) {
    return word;
  }
  std::string quoted = "'";
  for (const char letter : word) {
    quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
  }
  return quoted + "'";
}

void PrintDemo(const DemoArguments& arguments, const Shell& shell, const DemoWorld& world,
               const Answers& from_images, const Answers& from_features) {
  PrintWorld(world);
  PrintTable(from_images);
  fmt::print("\n");
  PrintSummary("sent images:", from_images.report);
  PrintSummary("sent features:", from_features.report);
  fmt::print(
      "\nPictures, photos and the map are in {}/. To ask the map in a browser, run\n"
      "  {} serve {}\n"
      "and open http://localhost:8080/ui.\n",
      arguments.output_dir, ShellWord(ProgramName(shell.program_path)),
      ShellWord(std::filesystem::absolute(world.map_path).lexically_normal().string()));
}

ExitCode RunDemo(const DemoArguments& arguments, const Shell& shell) {
  const std::filesystem::path output_dir = arguments.output_dir;
  Answers from_images;
  Answers from_features;
  DemoWorld world;
  {
    Progress progress(shell.progress_mode);
    world = MakeDemoWorld({output_dir, arguments.quick, arguments.seed}, &progress);
    ServerOptions server_options;
    server_options.map_path = world.map_path;
    server_options.port = 0;
    Server server(server_options);
    server.Start();
    LocalizeClient client(ClientOptions{.url = fmt::format("http://127.0.0.1:{}", server.port())});
    from_images = AskAll("ask by image", world.queries, &progress, [&](const EvalQuery& query) {
      return client.LocalizeImages(query.query, {ReadImageBytes(query.image_path)});
    });
    from_features =
        AskAll("ask by features", world.queries, &progress,
               [&](const EvalQuery& query) { return client.LocalizeFeatures(query.query); });
    server.Stop();
    DrawPictures(world, from_images.report, output_dir);
  }
  if (arguments.json) {
    PrintDemoJson(world, from_images.report, from_features.report);
  } else {
    PrintDemo(arguments, shell, world, from_images, from_features);
  }
  const int num_right = std::min(CountRight(from_images.report), CountRight(from_features.report));
  if (num_right < kMinShareRight * from_images.report.num_queries) {
    throw Error(ErrorCode::kInternal,
                "the demo failed: fewer than 80 % of the answers are within 0.5 m and "
                "2 degrees of the truth");
  }
  return ExitCode::kOk;
}

}  // namespace

void AddDemoCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("demo", "Map a rendered street and localize photos against it");
  auto arguments = std::make_shared<DemoArguments>();
  command
      ->add_option("--output", arguments->output_dir, "Output folder for map, photos and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_flag("--quick", arguments->quick, "Use half of the street and half of the photos");
  AddSeedOption(command, &arguments->seed, "Random seed of street, noise and codebook");
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "Fails if fewer than 80 % of the photos are localized within 0.5 m and 2 degrees.\n"
      "Example:\n"
      "  cairn demo --output demo-output");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunDemo(*arguments, *shell); };
  });
}

}  // namespace cairn
