// Which queries `cairn eval` asks, and what it takes as their true poses.
#ifndef CAIRN_CLI_EVAL_QUERIES_H_
#define CAIRN_CLI_EVAL_QUERIES_H_

#include <string>
#include <vector>

#include "cli/reconstruction_arguments.h"
#include "eval/eval_query.h"
#include "storage/map/map_store.h"

namespace cairn {

// What places the reference reconstruction on Earth.
enum class ReferenceSource {
  kAuto,       // The map if it holds three of the model's images, else the positions.
  kMap,        // The poses of the images that map and model share.
  kPositions,  // --georef or --gps, fitted over the whole model.
};

struct EvalQueryArguments {
  std::string query_list_path;  // Empty if the queries come from a reconstruction.
  ReconstructionArguments reconstruction;
  ReferenceSource reference_source = ReferenceSource::kAuto;
  std::string image_list_path;  // Names of the queries; empty: all images the map does not hold.
  std::string image_dir;
};

// Reads or makes the queries, without priors. Logs how the reference was placed. Throws
// Error(kInvalidArgument) if the arguments do not say enough, Error(kBadInput) if there is no query
// left or the reference does not fit.
std::vector<EvalQuery> LoadEvalQueries(const EvalQueryArguments& arguments, const MapSnapshot& map);

}  // namespace cairn

#endif  // CAIRN_CLI_EVAL_QUERIES_H_
