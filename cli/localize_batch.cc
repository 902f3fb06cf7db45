// `cairn localize --images`: where many photos were taken.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "cli/batch/localize_photos.h"
#include "cli/localize_arguments.h"
#include "cli/options/write_options.h"
#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/logging.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "core/wire/fingerprint.h"
#include "engine/localizer.h"

namespace cairn {
namespace {

void CheckBatchArguments(const LocalizeArguments& arguments) {
  const auto refuse = [](const std::string& message) {
    throw Error(ErrorCode::kInvalidArgument, message);
  };
  if (arguments.batch.output_path.empty()) {
    refuse("--images needs --output FILE.csv, .jsonl or, for hloc's lines, .txt");
  }
  ResultFormatOf(arguments.batch.output_path);
  if (!arguments.rig_path.empty() || !arguments.picture_path.empty()) {
    refuse("--rig and --picture are for one photo (--image)");
  }
}

// What the answers of a batch come from.
struct BatchSource {
  std::optional<Localizer> localizer;  // Without, the server answers.
  std::optional<MapSnapshot> map;      // One version for all photos.
};

BatchSource OpenSource(const LocalizeArguments& arguments) {
  BatchSource source;
  if (arguments.server_url.empty()) {
    source.localizer.emplace(Localizer::Open(arguments.map_path, arguments.options.localizer));
    source.map = source.localizer->map().Snapshot();
  }
  return source;
}

PhotoAnswerer AskLocalizer(const BatchSource& source, const FeatureExtractor& extractor) {
  return [&source, &extractor](PhotoQuery* photo) {
    photo->query.features = extractor.Extract(photo->photo.image);
    photo->photo.image = {};
    return source.localizer->LocalizeIn(*source.map, photo->query);
  };
}

PhotoAnswerer AskServer(const LocalizeArguments& arguments) {
  // A client sends all its photos in one orientation.
  auto clients = std::make_shared<std::array<std::unique_ptr<LocalizeClient>, 2>>();
  return [&arguments, clients](PhotoQuery* photo) {
    auto& client = (*clients)[photo->orientation == ImageOrientation::kUpright ? 1 : 0];
    if (client == nullptr) {
      ClientOptions options = ClientOptionsOf(arguments, photo->orientation);
      options.want_matches = false;
      client = std::make_unique<LocalizeClient>(options);
    }
    return client->LocalizeImages(photo->query, {photo->photo.bytes});
  };
}

void AddText(std::string_view text, Fingerprint* fingerprint) {
  fingerprint->Add(uint64_t{text.size()});
  fingerprint->Add(text);
}

void AddCamera(const std::optional<Camera>& camera, Fingerprint* fingerprint) {
  AddText(camera ? CameraModelName(camera->model()) : "", fingerprint);
  if (camera) {
    fingerprint->Add(static_cast<uint64_t>(camera->width_px()));
    fingerprint->Add(static_cast<uint64_t>(camera->height_px()));
    for (const double param : camera->params()) {
      fingerprint->Add(param);
    }
  }
}

void AddPrior(const std::optional<PositionPrior>& prior, Fingerprint* fingerprint) {
  fingerprint->Add(uint64_t{prior ? 1U : 0U});
  if (prior) {
    fingerprint->Add(prior->position.lat_rad);
    fingerprint->Add(prior->position.lon_rad);
    fingerprint->Add(prior->position.h_m);
    fingerprint->Add(prior->accuracy_m);
  }
}

// Names all that the rows depend on, but the bytes of the photos.
std::string RunDigest(const LocalizeArguments& arguments, const LocalizePhotosOptions& options,
                      const std::vector<ListedPhoto>& photos, const BatchSource& source) {
  Fingerprint fingerprint;
  AddText(CAIRN_VERSION, &fingerprint);
  AddText(OptionsAsJson(arguments.options), &fingerprint);
  AddText(arguments.server_url, &fingerprint);
  if (source.map) {
    const MapInfo info = source.map->Info();
    AddText(info.created_at, &fingerprint);
    fingerprint.Add(static_cast<uint64_t>(Value(info.version)));
    fingerprint.Add(static_cast<uint64_t>(info.payload_bytes));
  }
  AddText(options.frame.name, &fingerprint);
  for (const double number : options.frame.ecef_from_world.translation) {
    fingerprint.Add(number);
  }
  AddCamera(options.query.camera, &fingerprint);
  fingerprint.Add(options.query.focal_log_sigma.value_or(0.0));
  AddPrior(options.query.prior, &fingerprint);
  fingerprint.Add(uint64_t{options.query.exif_prior ? 1U : 0U});
  for (const double number : options.query.down_in_cam.value_or(Eigen::Vector3d::Zero())) {
    fingerprint.Add(number);
  }
  for (const ListedPhoto& photo : photos) {
    AddText(photo.name, &fingerprint);
    AddText(photo.path, &fingerprint);
    AddCamera(photo.camera, &fingerprint);
    AddPrior(photo.prior, &fingerprint);
  }
  return fmt::format("{:016x}", fingerprint.value());
}

std::vector<ListedPhoto> PhotosOf(const LocalizeArguments& arguments) {
  std::vector<ListedPhoto> photos =
      ReadPhotoList(arguments.batch.images, arguments.batch.image_dir);
  if (!arguments.batch.gps_path.empty()) {
    AddTablePriors(arguments.batch.gps_path, arguments.height, arguments.accuracy_m, &photos);
  }
  return photos;
}

void PrintBatchSummary(const LocalizeArguments& arguments, const WorldFrame& frame,
                       size_t num_photos, const ResultCounts& counts) {
  if (arguments.json) {
    nlohmann::ordered_json json = {{"output", arguments.batch.output_path},
                                   {"photos", num_photos},
                                   {"localized", counts.num_localized},
                                   {"reasons", nlohmann::ordered_json::object()},
                                   {"frame", frame.name}};
    for (const auto& [reason, count] : counts.num_of_reason) {
      json["reasons"][reason] = count;
    }
    fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    return;
  }
  fmt::print("localized    {} of {} photos\n", counts.num_localized, num_photos);
  for (const auto& [reason, count] : counts.num_of_reason) {
    fmt::print("{:>12} {}\n", count, Printable(reason));
  }
  fmt::print("written      {}; cam_from_world, world is {}\n",
             Printable(arguments.batch.output_path), frame.Text());
}

}  // namespace

void AddBatchOptions(CLI::App* command, BatchArguments* arguments) {
  arguments->num_threads = NumCores();
  command
      ->add_option("--images", arguments->images,
                   "Many photos: a folder, or a list with a photo a line: its name, or hloc's name "
                   "MODEL w h param...")
      ->type_name("DIR|LIST");
  auto* const images = command->get_option("--images");
  command
      ->add_option("--output", arguments->output_path,
                   "File for the answers to --images: .csv, .jsonl, or .txt for hloc's lines name "
                   "qw qx qy qz tx ty tz. A killed run goes on where it was")
      ->type_name("FILE")
      ->needs(images);
  command
      ->add_option("--image-dir", arguments->image_dir,
                   "Folder of the photos of a list. Default: that of the list")
      ->type_name("DIR")
      ->needs(images);
  command
      ->add_option("--gps", arguments->gps_path,
                   "Priors of --images as CSV: image,lat_deg,lon_deg,h_m[,accuracy_m]. Photos "
                   "without a row take --prior or their EXIF")
      ->type_name("CSV")
      ->needs(images);
  command
      ->add_option("--threads", arguments->num_threads,
                   "Photos of --images at once; the answers do not depend on it. Default: all "
                   "cores")
      ->check(CLI::Range(1, 1024))
      ->needs(images);
  AddWorldFrameOptions(command, "Frame of the poses in --output", FrameChoice::kEcef,
                       &arguments->frame);
}

ExitCode RunLocalizeBatch(const LocalizeArguments& arguments, ProgressMode progress_mode) {
  CheckBatchArguments(arguments);
  const std::vector<ListedPhoto> photos = PhotosOf(arguments);
  const BatchSource source = OpenSource(arguments);
  LocalizePhotosOptions options;
  options.query = QueryOptionsOf(arguments);
  options.query.with_pixels = source.localizer.has_value();
  options.frame =
      WorldFrameOf(arguments.batch.frame, FrameChoice::kEcef, source.map ? &*source.map : nullptr);
  options.num_threads = arguments.batch.num_threads;
  const SiftExtractor extractor(arguments.options.sift);
  options.make_answerer = [&] {
    return source.localizer ? AskLocalizer(source, extractor) : AskServer(arguments);
  };
  std::vector<std::string> names;
  for (const ListedPhoto& photo : photos) {
    names.push_back(photo.name);
  }
  ResultFile results(arguments.batch.output_path, RunDigest(arguments, options, photos, source),
                     std::move(names));
  if (results.is_restarted()) {
    LogInfo(
        "the rows of an earlier run are dropped: it had other photos, another map or other "
        "options");
  } else if (results.num_rows() > 0) {
    LogInfo("an earlier run has answered {} of {} photos", results.num_rows(), photos.size());
  }
  {
    Progress progress(progress_mode);
    options.progress = [&](int64_t done, int64_t total) {
      progress.Update("localize", done, total);
    };
    LocalizePhotos(photos, options, &results);
  }
  const ResultCounts counts = results.Finish();
  PrintBatchSummary(arguments, options.frame, photos.size(), counts);
  return counts.num_localized > 0 ? ExitCode::kOk : ExitCode::kNotLocalized;
}

}  // namespace cairn
