// The demo's map and queries: a rendered street that is mapped as `cairn map` maps photos.
#ifndef CAIRN_CLI_DEMO_DEMO_WORLD_H_
#define CAIRN_CLI_DEMO_DEMO_WORLD_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/progress.h"
#include "core/images/gray_image.h"
#include "eval/eval_query.h"
#include "ingest/ingest_report.h"
#include "ingest/place/fit_placement.h"

namespace cairn {

struct DemoWorldOptions {
  std::filesystem::path output_dir;
  bool quick = false;  // A shorter street and fewer queries.
  uint64_t seed = 1;
};

struct DemoWorld {
  std::string map_path;  // <output_dir>/street.gpkg
  IngestReport ingest;
  int num_mapping_photos = 0;
  int num_mapped = 0;        // Of these, those in the map.
  double gps_sigma_m = 0.0;  // Noise of their GPS per axis.
  // From the true poses of the mapped photos to those in the map, which stands where GPS says.
  PlacementFit map_from_earth;
  // Held-out photos with noisy prior and gravity. Their true poses are moved by `map_from_earth`,
  // so that errors of answers are those within the map. Their features are extracted from the
  // pixels. The photos are also files, see EvalQuery::image_path.
  std::vector<EvalQuery> queries;
  std::vector<GrayImage> photos;  // Parallel to queries.
};

// Replaces the results of an earlier demo in `output_dir`. The map is made of nothing but files:
// those in `photos`, without EXIF, and `positions.csv` with their GPS. Throws Error(kIo) if the
// folder cannot be written, and as MakeMapSession.
DemoWorld MakeDemoWorld(const DemoWorldOptions& options, Progress* progress);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_DEMO_WORLD_H_
