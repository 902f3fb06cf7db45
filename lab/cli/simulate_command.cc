// `cairn-lab simulate`: writes a simulated city as a map, as queries, and as files for other tools.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "cli/arguments.h"
#include "cli/choice_option.h"
#include "cli/query_features.h"
#include "core/angles.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "eval/pictures/picture_format.h"
#include "ingest/colmap/write_colmap.h"
#include "lab/city/city_world.h"
#include "lab/city/draw_city.h"
#include "lab/city/phone_sequence.h"
#include "lab/city/whole_city.h"
#include "lab/cli/lab_verbs.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxWholeCityBytes = 4e9;
constexpr double kGeorefAccuracyM = 0.05;

// Arguments of the command line. The preset provides those that are not given.
struct SimulateArguments {
  std::string map_path, queries_path, colmap_dir, sequence_dir, picture_path;
  std::string character = "old-town", size = "medium", center;
  std::optional<double> area_km2, relief_m, min_landmark_size_m, repeated_share, lifetime_factor;
  std::optional<int> num_passes, keyframe_keypoints, min_observations;
  std::optional<double> years, keyframe_spacing_m, deformation_m, clutter_ratio;
  std::optional<int> num_queries, num_keypoints;
  std::optional<double> mapped_fraction, mapped_log_sigma, query_years, gps_median_m, canyon_bias_m,
      gravity_deg;
  PhoneSequenceOptions sequence;
  uint64_t seed = 1;
  int num_threads = 2;
};

template <typename Value>
void Override(const std::optional<Value>& given, Value* value) {
  if (given) {
    *value = *given;
  }
}

CityWorldOptions WorldOptions(const SimulateArguments& arguments) {
  CityWorldOptions world = CityWorldPreset(CityCharacterFromName(arguments.character),
                                           CityWorldSizeFromName(arguments.size));
  if (!arguments.center.empty()) {
    world.city.center = ParseGeodetic("--center", arguments.center);
  }
  Override(arguments.area_km2, &world.city.area_km2);
  Override(arguments.relief_m, &world.city.relief_m);
  Override(arguments.min_landmark_size_m, &world.city.min_landmark_size_m);
  Override(arguments.repeated_share, &world.city.repeated_share);
  Override(arguments.lifetime_factor, &world.city.lifetime_factor);
  Override(arguments.num_passes, &world.mapping.num_passes);
  Override(arguments.keyframe_keypoints, &world.mapping.detector.max_keypoints);
  Override(arguments.min_observations, &world.mapping.min_observations);
  Override(arguments.years, &world.mapping.years);
  Override(arguments.keyframe_spacing_m, &world.mapping.keyframe_spacing_m);
  Override(arguments.deformation_m, &world.mapping.noise.deformation_m);
  Override(arguments.clutter_ratio, &world.mapping.clutter_ratio);
  Override(arguments.num_queries, &world.queries.num_queries);
  Override(arguments.num_keypoints, &world.queries.num_keypoints);
  Override(arguments.mapped_fraction, &world.queries.mapped_fraction);
  Override(arguments.mapped_log_sigma, &world.queries.mapped_log_sigma);
  Override(arguments.query_years, &world.queries.time_years);
  Override(arguments.gps_median_m, &world.queries.noise.gps_median_m);
  Override(arguments.canyon_bias_m, &world.queries.noise.canyon_bias_m);
  if (arguments.gravity_deg) {
    world.queries.noise.gravity_sigma_rad = *arguments.gravity_deg * kRadPerDeg;
  }
  world.city.seed = world.mapping.seed = world.queries.seed = arguments.seed;
  world.descriptors.seed = arguments.seed;
  world.num_threads = arguments.num_threads;
  world.Validate();
  return world;
}

void MakeFolder(const std::string& dir) {
  std::error_code failure;
  fs::create_directories(dir, failure);
  if (failure) {
    throw Error(ErrorCode::kIo, dir + ": " + failure.message());
  }
}

void WriteMap(const SimulateArguments& arguments, const CityWorldOptions& world,
              Progress* progress) {
  std::vector<EvalQuery> queries =
      BuildCityWorld(world, arguments.map_path,
                     [&](int done, int total) { progress->Update("mapping tiles", done, total); });
  const MapInfo info = MapStore::Open(arguments.map_path, OpenMode::kReadOnly).Snapshot().Info();
  fmt::print("map              {} tiles, {} images, {} landmarks, {:.1f} MB\n", info.num_tiles,
             info.num_keyframes, info.num_landmarks,
             1e-6 * static_cast<double>(info.payload_bytes));
  if (!arguments.queries_path.empty()) {
    WriteQueryListWithFeatures(arguments.queries_path, &queries);
    fmt::print("queries          {} in {}\n", queries.size(), arguments.queries_path);
  }
}

// Writes camera positions in the format of `cairn ingest --georef`. The model's world frame is
// `site`.
void WriteGeoref(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                 const std::string& path) {
  std::string table = "image,lat_deg,lon_deg,h_m,accuracy_m\n";
  for (const ReconImage& image : reconstruction.images) {
    const Geodetic at =
        GeodeticFromEcef(ecef_from_world * image.cam_from_world.Inverse().translation);
    table += fmt::format("{},{:.10f},{:.10f},{:.4f},{}\n", image.name, at.lat_deg(), at.lon_deg(),
                         at.h_m, kGeorefAccuracyM);
  }
  WriteTextFile(path, table);
}

void WriteColmap(const SimulateArguments& arguments, const CityWorldOptions& world,
                 Progress* progress) {
  const City city(world.city);
  const DescriptorModel model(world.descriptors);
  const SimulatedMapping mapping(city, model, world.mapping);
  const Reconstruction whole =
      MapWholeCity(mapping, world.num_threads, kMaxWholeCityBytes,
                   [&](int done, int total) { progress->Update("mapping tiles", done, total); });
  const std::string model_dir = arguments.colmap_dir + "/sparse/0";
  MakeFolder(model_dir);
  WriteColmapModel(whole, model_dir, ColmapModelFormat::kBinary);
  WriteColmapDatabase(whole, arguments.colmap_dir + "/database.db", {});
  WriteGeoref(whole, mapping.EcefFromWorld(), arguments.colmap_dir + "/georef.csv");
  fmt::print("COLMAP           {} images, {} landmarks in {}\n", whole.images.size(),
             whole.landmarks.size(), arguments.colmap_dir);
}

void WriteSequence(const SimulateArguments& arguments, const CityWorldOptions& world) {
  PhoneSequenceOptions options = arguments.sequence;
  options.seed = arguments.seed;
  options.time_years = world.queries.time_years;
  const PhoneSequence sequence = SimulatePhoneSequence(City(world.city), options);
  MakeFolder(arguments.sequence_dir);
  WriteEurocSequence(sequence, options.imu_noise, arguments.sequence_dir);
  fmt::print("sequence         {} inertial samples, {} frames in {}\n", sequence.imu.size(),
             sequence.frames.size(), arguments.sequence_dir);
}

void WritePlan(const SimulateArguments& arguments, const CityWorldOptions& world) {
  const City city(world.city);
  const DescriptorModel model(world.descriptors);
  DrawCity(arguments.picture_path, SimulatedMapping(city, model, world.mapping),
           PhoneQueries(city, model, world.queries));
  fmt::print("picture          {}\n", arguments.picture_path);
}

ExitCode RunSimulate(const SimulateArguments& arguments, ProgressMode progress_mode) {
  const CityWorldOptions world = WorldOptions(arguments);
  if (arguments.map_path.empty() && arguments.colmap_dir.empty() &&
      arguments.sequence_dir.empty() && arguments.picture_path.empty()) {
    throw Error(
        ErrorCode::kInvalidArgument,
        "no output requested: give --map FILE, --colmap DIR, --sequence DIR or --picture FILE");
  }
  Progress progress(progress_mode);
  if (!arguments.picture_path.empty()) {
    RequirePictureFormat("--picture", arguments.picture_path);
  }
  if (!arguments.map_path.empty()) {
    WriteMap(arguments, world, &progress);
  }
  if (!arguments.colmap_dir.empty()) {
    WriteColmap(arguments, world, &progress);
  }
  if (!arguments.sequence_dir.empty()) {
    WriteSequence(arguments, world);
  }
  if (!arguments.picture_path.empty()) {
    WritePlan(arguments, world);
  }
  return ExitCode::kOk;
}

void AddOutputOptions(CLI::App* command, SimulateArguments* arguments) {
  CLI::Option* map = command
                         ->add_option("--map", arguments->map_path,
                                      "Write a map, tile by tile; the file must not exist")
                         ->type_name("FILE");
  command
      ->add_option("--queries", arguments->queries_path,
                   "Write a query list with feature files, for 'cairn eval --queries'")
      ->type_name("FILE")
      ->needs(map);
  command
      ->add_option("--colmap", arguments->colmap_dir,
                   "Write sparse/0, database.db and georef.csv; small cities only")
      ->type_name("DIR");
  command
      ->add_option("--sequence", arguments->sequence_dir,
                   "Write a walk in EuRoC's layout: inertial samples, tracks, truth")
      ->type_name("DIR");
  command->add_option("--picture", arguments->picture_path, "Draw a plan; small cities only")
      ->type_name("PNG");
}

void AddCityOptions(CLI::App* command, SimulateArguments* arguments) {
  AddWordOption(
      command, "--character", {"old-town", "grid", "suburb", "high-rise"},
      [arguments](const std::string& word) { arguments->character = word; },
      "Kind and place of the city")
      ->default_str(arguments->character);
  AddWordOption(
      command, "--size", {"quick", "medium", "paper"},
      [arguments](const std::string& word) { arguments->size = word; },
      "Preset for the options below")
      ->default_str(arguments->size);
  command
      ->add_option("--center", arguments->center,
                   "Center of the city: degrees and ellipsoidal meters")
      ->type_name("LAT,LON,H");
  command->add_option("--area", arguments->area_km2, "Mapped area, square kilometers")
      ->type_name("KM2");
  command->add_option("--relief", arguments->relief_m, "Height range of the ground, meters")
      ->type_name("M");
  command
      ->add_option("--min-landmark-size", arguments->min_landmark_size_m,
                   "Smallest landmark, meters; half the size gives four times the landmarks")
      ->type_name("M");
  command->add_option("--repeated-share", arguments->repeated_share,
                      "Share of facade landmarks that repeat, 0 to 0.95");
  command->add_option("--lifetime-factor", arguments->lifetime_factor,
                      "Factor on the lifetimes of things");
  AddSeedOption(command, &arguments->seed, "Seed of everything");
  command
      ->add_option("--threads", arguments->num_threads,
                   "Threads; the result does not depend on them")
      ->capture_default_str();
}

void AddMappingOptions(CLI::App* command, SimulateArguments* arguments) {
  command->add_option("--passes", arguments->num_passes, "Passes of the mapping cars");
  command->add_option("--years", arguments->years, "Years from the first pass to the last");
  command
      ->add_option("--keyframe-spacing", arguments->keyframe_spacing_m,
                   "Distance between keyframes, meters")
      ->type_name("M");
  command->add_option("--image-keypoints", arguments->keyframe_keypoints,
                      "Most keypoints per mapping image");
  command->add_option("--min-observations", arguments->min_observations,
                      "Fewest observations of a landmark");
  command
      ->add_option("--deformation", arguments->deformation_m,
                   "Deformation of the map, meters per axis")
      ->type_name("M");
  command->add_option("--clutter", arguments->clutter_ratio,
                      "Number of keypoints without a landmark for each keypoint with one");
}

void AddQueryOptions(CLI::App* command, SimulateArguments* arguments) {
  command->add_option("--num-queries", arguments->num_queries,
                      "Number of queries: photos on the sidewalk");
  command->add_option("--keypoints", arguments->num_keypoints, "Keypoints per query");
  command->add_option(
      "--mapped-fraction", arguments->mapped_fraction,
      "Share of a query's keypoints that show a mapped landmark: median over queries");
  command->add_option("--mapped-log-sigma", arguments->mapped_log_sigma,
                      "Standard deviation of that share's logarithm; 0: equal in all queries");
  command->add_option("--query-years", arguments->query_years,
                      "Time of the queries, years after the first pass");
  command
      ->add_option("--gps-noise", arguments->gps_median_m,
                   "Median standard deviation of GPS, meters")
      ->type_name("M");
  command->add_option("--canyon-bias", arguments->canyon_bias_m, "GPS error between houses, meters")
      ->type_name("M");
  command
      ->add_option("--gravity-noise-deg", arguments->gravity_deg, "Tilt error of gravity, degrees")
      ->type_name("DEG");
  command
      ->add_option("--duration", arguments->sequence.duration_s,
                   "Duration of the sequence, seconds")
      ->capture_default_str();
  command
      ->add_option("--frame-rate", arguments->sequence.frame_rate_hz,
                   "Frames per second of the sequence")
      ->capture_default_str();
}

}  // namespace

void AddSimulateCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("simulate", "Simulate a city with ground truth");
  auto arguments = std::make_shared<SimulateArguments>();
  AddOutputOptions(command, arguments.get());
  AddCityOptions(command, arguments.get());
  AddMappingOptions(command, arguments.get());
  AddQueryOptions(command, arguments.get());
  for (const char* number :
       {"--area", "--relief", "--min-landmark-size", "--repeated-share", "--lifetime-factor",
        "--years", "--keyframe-spacing", "--deformation", "--clutter", "--mapped-fraction",
        "--mapped-log-sigma", "--query-years", "--gps-noise", "--canyon-bias",
        "--gravity-noise-deg", "--duration", "--frame-rate"}) {
    command->get_option(number)->check(NumberWithin(0.0, 1e9));
  }
  command->footer(
      "Equal options give equal bytes. docs/simulated_city.md describes the simulation and its "
      "limits.\n"
      "Example:\n"
      "  cairn-lab simulate --character grid --map city.gpkg --queries queries.json\n"
      "  cairn eval city.gpkg --queries queries.json --given-priors");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunSimulate(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
