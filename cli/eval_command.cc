// `cairn eval`: measures how well and how fast a map localizes queries with known poses.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/choice_option.h"
#include "cli/client_key.h"
#include "cli/eval_queries.h"
#include "cli/index_option.h"
#include "cli/make_folders.h"
#include "cli/options_file.h"
#include "cli/query_features.h"
#include "cli/shell.h"
#include "core/angles.h"
#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/file_bytes.h"
#include "core/parallel_for.h"
#include "engine/localizer.h"
#include "eval/elsewhere.h"
#include "eval/evaluation.h"
#include "eval/report/report_page.h"
#include "eval/stated_focal.h"
#include "http/client.h"

namespace cairn {
namespace {

enum class SendAs { kImage, kFeatures };
enum class FeatureSource { kModel, kExtract };

struct EvalArguments {
  std::string map_path;
  EvalQueryArguments queries;
  bool no_prior = false;
  bool no_gravity = false;
  bool given_priors = false;
  double prior_offset_m = 0.0;
  bool elsewhere = false;
  bool permute_descriptors = false;
  StatedFocalOptions focal;
  double focal_error_percent = 0.0;
  std::optional<double> focal_sigma_percent;
  std::string server_url;
  std::string ca_file;
  ClientKeyArguments key;
  SendAs send_as = SendAs::kFeatures;
  FeatureSource feature_source = FeatureSource::kModel;
  CairnOptions options;
  std::string json_path;
  std::string csv_path;
  std::string matches_path;
  std::string report_dir;
  int num_threads = 1;
};

// Answers one query. Each worker has its own Answerer.
using Answerer = std::function<LocalizeResult(const EvalQuery&)>;

bool NeedsImages(const EvalArguments& arguments, const EvalQuery& query) {
  const bool sends_image = !arguments.server_url.empty() && arguments.send_as == SendAs::kImage;
  return sends_image || arguments.feature_source == FeatureSource::kExtract ||
         query.query.features.size() == 0;
}

// Extracts features if the arguments ask for extracted features or if a query has none.
void ExtractFeatures(const EvalArguments& arguments, Progress* progress,
                     std::vector<EvalQuery>* queries) {
  const SiftExtractor extractor(arguments.options.sift);
  const auto total = static_cast<int64_t>(queries->size());
  for (int64_t i = 0; i < total; ++i) {
    EvalQuery& query = (*queries)[i];
    if (!NeedsImages(arguments, query)) {
      continue;
    }
    RequirePhoto(query);
    if (arguments.server_url.empty() || arguments.send_as == SendAs::kFeatures) {
      ExtractQueryFeatures(extractor, &query);
    }
    progress->Update("extract", i + 1, total);
  }
}

Answerer MakeAnswerer(const EvalArguments& arguments, const Localizer& localizer) {
  if (arguments.server_url.empty()) {
    return [&localizer](const EvalQuery& query) { return localizer.Localize(query.query); };
  }
  auto client =
      std::make_shared<LocalizeClient>(ClientOptions{.url = arguments.server_url,
                                                     .ca_file = arguments.ca_file,
                                                     .api_key = arguments.key.Read(),
                                                     .allow_plain_key = arguments.key.allow_plain,
                                                     .want_matches = !arguments.report_dir.empty(),
                                                     .exif_prior = false});
  if (arguments.send_as == SendAs::kFeatures) {
    return [client](const EvalQuery& query) { return client->LocalizeFeatures(query.query); };
  }
  return [client](const EvalQuery& query) {
    return client->LocalizeImages(query.query, {ReadImageBytes(query.image_path)});
  };
}

// Runs all queries. The results are parallel to the queries.
std::vector<LocalizeResult> AnswerAll(const EvalArguments& arguments, const Localizer& localizer,
                                      const std::vector<EvalQuery>& queries, Progress* progress) {
  const auto num_queries = static_cast<int64_t>(queries.size());
  std::vector<LocalizeResult> results(queries.size());
  std::atomic<int64_t> next_query = 0;
  std::mutex progress_mutex;
  int64_t num_done = 0;
  ParallelFor(arguments.num_threads, arguments.num_threads, [&](int /*worker*/) {
    const Answerer answer = MakeAnswerer(arguments, localizer);
    for (int64_t i = next_query++; i < num_queries; i = next_query++) {
      results[i] = answer(queries[i]);
      const std::lock_guard lock(progress_mutex);
      progress->Update("localize", ++num_done, num_queries);
    }
  });
  return results;
}

void PrintMapSize(const MapSnapshot& map) {
  const MapInfo info = map.Info();
  if (info.num_tiles == 0) {
    return;
  }
  const auto num_tiles = static_cast<double>(info.num_tiles);
  fmt::print("map: {} tiles, {:.1f} kB per tile, {:.1f} bytes per landmark\n", info.num_tiles,
             1e-3 * static_cast<double>(info.payload_bytes) / num_tiles,
             static_cast<double>(info.payload_bytes) /
                 static_cast<double>(std::max<int64_t>(1, info.num_landmarks)));
}

StatedFocalOptions FocalOptionsOf(const EvalArguments& arguments) {
  StatedFocalOptions options = arguments.focal;
  options.error = 0.01 * arguments.focal_error_percent;
  if (arguments.focal_sigma_percent) {
    options.sigma = 0.01 * *arguments.focal_sigma_percent;
  }
  options.seed = arguments.options.localizer.seed;
  options.Validate();
  return options;
}

PriorNoiseOptions NoiseOf(const EvalArguments& arguments) {
  PriorNoiseOptions noise = arguments.options.noise;
  noise.with_prior = !arguments.no_prior;
  noise.with_gravity = !arguments.no_gravity;
  noise.seed = arguments.options.localizer.seed;
  noise.Validate();
  return noise;
}

// Loads the queries and gives them the priors, gravity and focal lengths that the arguments state.
std::vector<EvalQuery> PrepareQueries(const EvalArguments& arguments,
                                      const PriorNoiseOptions& noise, const Localizer& localizer) {
  std::vector<EvalQuery> queries =
      LoadEvalQueries(arguments.queries, arguments.options.georegister, localizer.map().Snapshot());
  if (arguments.elsewhere) {
    PlaceElsewhere(KeyframePlaces(localizer.map().Snapshot()), noise.seed, &queries);
  }
  if (!arguments.given_priors) {
    AddNoisyPriors(noise, &queries);
  }
  if (arguments.prior_offset_m > 0.0) {
    OffsetPriors(arguments.prior_offset_m, noise.seed, &queries);
  }
  StateFocalLengths(FocalOptionsOf(arguments), &queries);
  return queries;
}

void WriteReportFolder(const EvalArguments& arguments, const MapSnapshot& map,
                       const std::vector<EvalQuery>& queries, const EvalReport& report) {
  const std::string folder = arguments.report_dir + "/";
  WriteTextFile(folder + "report.json", ReportAsJson(report));
  WriteTextFile(folder + "answers.csv", ReportAsCsv(report));
  WriteTextFile(folder + "index.html", MakeReportPage(arguments.map_path, map, queries, report));
}

void WriteReports(const EvalArguments& arguments, const MapSnapshot& map,
                  const std::vector<EvalQuery>& queries, const EvalReport& report) {
  if (!arguments.report_dir.empty()) {
    WriteReportFolder(arguments, map, queries, report);
  }
  if (!arguments.json_path.empty()) {
    WriteTextFile(arguments.json_path, ReportAsJson(report));
  }
  if (!arguments.csv_path.empty()) {
    WriteTextFile(arguments.csv_path, ReportAsCsv(report));
  }
  if (!arguments.matches_path.empty()) {
    WriteTextFile(arguments.matches_path, MatchesAsCsv(queries, report));
  }
}

ExitCode RunEval(const EvalArguments& arguments, ProgressMode progress_mode) {
  const PriorNoiseOptions noise = NoiseOf(arguments);
  if (!arguments.report_dir.empty()) {
    MakeFolders(arguments.report_dir);  // Before the work begins.
  }
  const Localizer localizer = Localizer::Open(arguments.map_path, arguments.options.localizer);
  std::vector<EvalQuery> queries = PrepareQueries(arguments, noise, localizer);
  std::vector<LocalizeResult> results;
  {
    Progress progress(progress_mode);
    ExtractFeatures(arguments, &progress, &queries);
    if (arguments.permute_descriptors) {
      PermuteDescriptors(noise.seed, &queries);
    }
    results = AnswerAll(arguments, localizer, queries, &progress);
  }
  const EvalReport report = MeasureResults(queries, std::move(results));
  const bool is_chance = arguments.elsewhere || arguments.permute_descriptors;
  fmt::print("{}",
             is_chance ? ElsewhereAsText(MeasureElsewhere(report.answers)) : ReportAsText(report));
  PrintMapSize(localizer.map().Snapshot());
  WriteReports(arguments, localizer.map().Snapshot(), queries, report);
  return ExitCode::kOk;
}

void AddQuerySourceOptions(CLI::App* command, EvalQueryArguments* arguments) {
  static constexpr EnumName<ReferenceSource> kSources[] = {
      {"auto", ReferenceSource::kAuto},
      {"map", ReferenceSource::kMap},
      {"positions", ReferenceSource::kPositions}};
  CLI::Option* list = command
                          ->add_option("--queries", arguments->query_list_path,
                                       "Query list with reference poses (JSON)")
                          ->type_name("FILE");
  AddReconstructionOptions(command, &arguments->reconstruction);
  command->get_option("--model")->excludes(list);
  AddChoiceOption(
      command, "--align-to", NamedChoice(&arguments->reference_source, kSources),
      "Reference that places the model: the images shared with the map, or the positions");
  command
      ->add_option("--images", arguments->image_list_path,
                   "File with the images of the model to query, one name per line. Default: all "
                   "that are not in the map")
      ->type_name("FILE");
  command
      ->add_option("--image-dir", arguments->image_dir,
                   "Folder of the model's photos. Without --database, the features come from them")
      ->type_name("DIR");
}

void AddNoiseOptions(CLI::App* command, EvalArguments* arguments) {
  command
      ->add_option("--prior-noise", arguments->options.noise.position_sigma_m,
                   "Standard deviation of the position prior, meters per axis")
      ->check(NumberWithin(0.0, 1e6))
      ->type_name("M")
      ->capture_default_str();
  command
      ->add_option_function<double>(
          "--gravity-noise-deg",
          [noise = &arguments->options.noise](double sigma_deg) {
            noise->gravity_sigma_rad = sigma_deg * kRadPerDeg;
          },
          "Standard deviation of the gravity direction, degrees")
      ->check(NumberWithin(0.0, 180.0))
      ->type_name("DEG")
      ->default_str("1");
  command->add_flag("--no-prior", arguments->no_prior, "Leave out the position prior");
  command->add_flag("--no-gravity", arguments->no_gravity, "Leave out the gravity prior");
  command
      ->add_flag("--given-priors", arguments->given_priors,
                 "Use position and gravity of the query list unchanged")
      ->needs("--queries")
      ->excludes("--no-prior", "--no-gravity", "--prior-noise", "--gravity-noise-deg");
  command
      ->add_option(
          "--prior-offset", arguments->prior_offset_m,
          "Move each position prior by this distance, meters; its stated accuracy stays unchanged")
      ->type_name("M")
      ->check(NumberWithin(0.0, 1e6))
      ->capture_default_str();
  AddSeedOption(command, &arguments->options.localizer.seed,
                "Random seed of the noise and of the localizer");
}

void AddElsewhereOptions(CLI::App* command, EvalArguments* arguments) {
  command
      ->add_flag("--elsewhere", arguments->elsewhere,
                 "The queries show nothing of the map: place each at one of the map's keyframes "
                 "and count the false answers")
      ->excludes("--given-priors");
  command->add_flag("--permute-descriptors", arguments->permute_descriptors,
                    "Make such queries from any photos: permute the descriptors among the "
                    "keypoints and count the false answers");
}

void AddFocalOptions(CLI::App* command, EvalArguments* arguments) {
  CLI::Option* error = command
                           ->add_option("--focal-error", arguments->focal_error_percent,
                                        "Error of the focal length that queries state, percent: "
                                        "too long or too short at random")
                           ->check(NumberWithin(-99.0, 1e4))
                           ->type_name("PCT")
                           ->capture_default_str();
  CLI::Option* sigma = command
                           ->add_option("--focal-sigma", arguments->focal_sigma_percent,
                                        "Standard deviation of the focal length that queries "
                                        "state, percent. Default: none stated")
                           ->check(PositiveNumber())
                           ->type_name("PCT");
  command
      ->add_flag("--unknown-camera", arguments->focal.withheld,
                 "Queries state only the size of their images")
      ->excludes(error, sigma);
}

void AddTransportOptions(CLI::App* command, EvalArguments* arguments) {
  static constexpr EnumName<SendAs> kSendAs[] = {{"image", SendAs::kImage},
                                                 {"features", SendAs::kFeatures}};
  static constexpr EnumName<FeatureSource> kFeatureSources[] = {
      {"model", FeatureSource::kModel}, {"extract", FeatureSource::kExtract}};
  CLI::Option* server = command
                            ->add_option("--server", arguments->server_url,
                                         "Query this server instead of the map file")
                            ->type_name("URL");
  AddCaOption(command, server, &arguments->ca_file);
  AddClientKeyOptions(command, server, &arguments->key);
  AddChoiceOption(command, "--send", NamedChoice(&arguments->send_as, kSendAs),
                  "Data to send to the server")
      ->needs(server);
  AddChoiceOption(command, "--features", NamedChoice(&arguments->feature_source, kFeatureSources),
                  "Use the model's features, or extract new ones from the photos");
  command->add_option("--threads", arguments->num_threads, "Queries run in parallel")
      ->check(CLI::Range(1, 256))
      ->type_name("N")
      ->capture_default_str();
}

}  // namespace

void AddEvalCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("eval", "Measure accuracy and speed against known poses");
  auto arguments = std::make_shared<EvalArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  AddOptionsFile(command, &arguments->options);
  AddQuerySourceOptions(command, &arguments->queries);
  AddNoiseOptions(command, arguments.get());
  AddElsewhereOptions(command, arguments.get());
  AddFocalOptions(command, arguments.get());
  AddTransportOptions(command, arguments.get());
  AddIndexOption(command, &arguments->options.localizer.matching.index.kind);
  command
      ->add_option(
          "--report", arguments->report_dir,
          "Write a page for a browser to this folder: the map in plan, curves, calibration, "
          "times, and the worst photos with their matches")
      ->excludes("--elsewhere", "--permute-descriptors")
      ->type_name("DIR");
  command->add_option("--json", arguments->json_path, "Write the report as JSON")
      ->type_name("FILE");
  command->add_option("--csv", arguments->csv_path, "Write a CSV with one line per answer")
      ->type_name("FILE");
  command
      ->add_option("--matches-csv", arguments->matches_path,
                   "Write a CSV with one line per inlier and its deviation from the landmark")
      ->type_name("FILE");
  command
      ->add_option("--min-score", arguments->options.localizer.answer.min_score,
                   "Lowest score of an answer. Answers below it count as not localized (no effect "
                   "with --server)")
      ->check(NumberWithin(-1e9, 1e9))
      ->capture_default_str();
  command->footer(
      "Example:\n"
      "  cairn eval city.gpkg --model sparse/0 --database database.db --images held_out.txt");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunEval(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
