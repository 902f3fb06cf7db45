// The command line of `cairn localize`, for one photo and for many.
#ifndef CAIRN_CLI_LOCALIZE_ARGUMENTS_H_
#define CAIRN_CLI_LOCALIZE_ARGUMENTS_H_

#include <optional>
#include <string>

#include "cli/batch/photo_query.h"
#include "cli/client_key.h"
#include "cli/exit_codes.h"
#include "cli/options/cairn_options.h"
#include "cli/progress.h"
#include "cli/world_frame_option.h"
#include "core/geoid.h"
#include "http/client.h"

namespace cairn {

// Of many photos.
struct BatchArguments {
  std::string images;       // A folder or a list.
  std::string output_path;  // .csv, .jsonl or .txt.
  std::string image_dir;
  std::string gps_path;
  int num_threads = 1;
  WorldFrameArguments frame;
};

struct LocalizeArguments {
  std::string map_path;
  std::string server_url;
  std::string ca_file;
  ClientKeyArguments key;
  std::string image_path;
  std::string rig_path;  // Empty for one camera.
  BatchArguments batch;
  std::optional<std::string> camera;
  std::optional<double> focal_sigma_percent;
  std::optional<std::string> prior;
  std::optional<HeightReference> height;
  double accuracy_m = 15.0;
  bool exif_prior = true;
  std::optional<std::string> gravity;
  std::string picture_path;
  CairnOptions options;
  bool json = false;
};

PhotoQueryOptions QueryOptionsOf(const LocalizeArguments& arguments);

// For photos of this orientation.
ClientOptions ClientOptionsOf(const LocalizeArguments& arguments, ImageOrientation orientation);

// Adds --images and what belongs to it.
void AddBatchOptions(CLI::App* command, BatchArguments* arguments);

// Localizes the photos of --images and prints a summary. Throws Error(kInvalidArgument) for
// arguments that do not go with it.
ExitCode RunLocalizeBatch(const LocalizeArguments& arguments, ProgressMode progress_mode);

}  // namespace cairn

#endif  // CAIRN_CLI_LOCALIZE_ARGUMENTS_H_
