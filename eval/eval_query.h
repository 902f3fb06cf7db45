// Queries with reference poses, and how they are made and stored.
#ifndef CAIRN_EVAL_EVAL_QUERY_H_
#define CAIRN_EVAL_EVAL_QUERY_H_

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/rigid3.h"
#include "engine/query/localize_query.h"
#include "ingest/sfm/reconstruction.h"

namespace cairn {

struct EvalQuery {
  std::string name;        // Image name.
  std::string image_path;  // Empty if there is only the feature set.
  // A file of features (docs/formats/features_v1.md) that stands for the image; may be empty.
  std::string features_path;
  LocalizeQuery query;    // Features may be empty if one of the paths is set.
  Rigid3d cam_from_ecef;  // Reference pose.
};

// Seeded by the query's name, so that a query draws the same numbers in whatever list it stands.
std::mt19937_64 GeneratorOfQuery(const EvalQuery& query, uint64_t seed);

// Noise that turns reference poses into what a phone would send.
struct PriorNoiseOptions {
  double position_sigma_m = 10.0;  // Per horizontal axis; reported accuracy is its 68 % radius.
  double height_sigma_m = 5.0;
  double gravity_sigma_rad = 0.0174532925;  // Of the tilt about each of two axes across it.
  bool with_prior = true;
  bool with_gravity = true;
  uint64_t seed = 1;

  void Validate() const;
};

// Sets prior and gravity of each query to its reference pose plus noise, which depends on the seed
// and the query's name alone (docs/math/metrics.md). Validates the options.
void AddNoisyPriors(const PriorNoiseOptions& options, std::vector<EvalQuery>* queries);

// Moves the position of each prior by `distance_m` (finite) in a horizontal direction that depends
// on the seed and the query's name alone. The accuracy stays as it was stated, so it is wrong.
void OffsetPriors(double distance_m, uint64_t seed, std::vector<EvalQuery>* queries);

// Queries from the images of a georeferenced reconstruction: features from the reconstruction,
// reference poses from it. `image_dir` may be empty.
std::vector<EvalQuery> QueriesFromReconstruction(const Reconstruction& reconstruction,
                                                 const Sim3d& ecef_from_world,
                                                 const std::string& image_dir);

// JSON file of queries whose features come from images or feature files, which are not read here;
// docs/formats/query_list_v1.md. Paths are relative to the file. Throws Error(kBadInput) naming
// file and field.
std::vector<EvalQuery> ReadQueryList(const std::string& path);
void WriteQueryList(const std::string& path, const std::vector<EvalQuery>& queries);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVAL_QUERY_H_
