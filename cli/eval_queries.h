// The queries of `cairn eval` and their reference poses.
#ifndef CAIRN_CLI_EVAL_QUERIES_H_
#define CAIRN_CLI_EVAL_QUERIES_H_

#include <string>
#include <vector>

#include "cli/reconstruction_arguments.h"
#include "eval/eval_query.h"
#include "storage/map/map_store.h"

namespace cairn {

// The source that places the reference reconstruction on Earth.
enum class ReferenceSource {
  kAuto,       // The map if it contains three of the model's images, else the positions.
  kMap,        // The poses of the images that map and model share.
  kPositions,  // --georef or --gps, fitted over the whole model.
};

struct EvalQueryArguments {
  std::string query_list_path;  // Empty if the queries come from a reconstruction.
  ReconstructionArguments reconstruction;
  ReferenceSource reference_source = ReferenceSource::kAuto;
  std::string image_list_path;  // Names of the query images. If empty, all images that the map does
                                // not contain.
  std::string image_dir;
};

// Reads or makes the queries, without priors. Logs how the reference was placed. Throws
// Error(kInvalidArgument) if arguments are missing, and Error(kBadInput) if no query remains or the
// reference does not fit.
std::vector<EvalQuery> LoadEvalQueries(const EvalQueryArguments& arguments,
                                       const GeoregisterOptions& georegister,
                                       const MapSnapshot& map);

}  // namespace cairn

#endif  // CAIRN_CLI_EVAL_QUERIES_H_
