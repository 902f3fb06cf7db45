// The demo's map and queries, from a street that the demo renders, reconstructs and ingests.
#ifndef CAIRN_CLI_DEMO_DEMO_WORLD_H_
#define CAIRN_CLI_DEMO_DEMO_WORLD_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/progress.h"
#include "core/images/gray_image.h"
#include "eval/eval_query.h"
#include "ingest/ingest_session.h"

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
  // Held-out photos with true poses and noisy prior and gravity. Their features are extracted from
  // the pixels. The photos are also files, see EvalQuery::image_path.
  std::vector<EvalQuery> queries;
  std::vector<GrayImage> photos;  // Parallel to queries.
};

// Replaces the results of an earlier demo in `output_dir`. Throws Error(kIo) if the folder cannot
// be written.
DemoWorld MakeDemoWorld(const DemoWorldOptions& options, Progress* progress);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_DEMO_WORLD_H_
