// Queries with reference poses: how to make, change, read and write them.
#ifndef CAIRN_EVAL_EVAL_QUERY_H_
#define CAIRN_EVAL_EVAL_QUERY_H_

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/angles.h"
#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "engine/query/localize_query.h"

namespace cairn {

// Where reference poses are right: on Earth, or relative to the map, wherever the map itself
// stands.
enum class ReferenceFrame { kEarth, kMap };

struct EvalQuery {
  std::string name;        // Image name.
  std::string image_path;  // Empty if the query has only features.
  // A file of features (docs/formats/features_v1.md) that replaces the image; may be empty.
  std::string features_path;
  LocalizeQuery query;    // The features may be empty if one of the paths is set.
  Rigid3d cam_from_ecef;  // Reference pose.
  ReferenceFrame reference_frame = ReferenceFrame::kEarth;
  // The 68 % radii of the reference pose itself; 0: it is exact.
  double reference_radius_m = 0.0, reference_radius_rad = 0.0;
};

// A generator seeded by the query's name and `seed`, so that a query draws the same numbers in
// every list.
std::mt19937_64 GeneratorOfQuery(const EvalQuery& query, uint64_t seed);

// Noise that turns reference poses into the priors that a phone would send.
struct PriorNoiseOptions {
  double position_sigma_m = 10.0;  // Per horizontal axis. The reported accuracy is the 68 % radius.
  double height_sigma_m = 5.0;
  double gravity_sigma_rad = kRadPerDeg;  // 1 degree. Of the tilt about each of two axes
                                          // perpendicular to gravity.
  bool with_prior = true;
  bool with_gravity = true;
  uint64_t seed = 1;

  void Validate() const;
};

// Sets prior and gravity of each query to those of its reference pose plus noise. The noise depends
// only on the seed and the query's name (docs/math/metrics.md). Validates the options.
void AddNoisyPriors(const PriorNoiseOptions& options, std::vector<EvalQuery>* queries);

// Moves the position of each prior by `distance_m` (finite) in a horizontal direction. The
// direction depends only on the seed and the query's name. The stated accuracy stays unchanged and
// is therefore wrong.
void OffsetPriors(double distance_m, uint64_t seed, std::vector<EvalQuery>* queries);

// Makes queries from the images of a georeferenced reconstruction, with its features and its poses
// as reference. `image_dir` may be empty.
std::vector<EvalQuery> QueriesFromReconstruction(const Reconstruction& reconstruction,
                                                 const Sim3d& ecef_from_world,
                                                 const std::string& image_dir);

// Reads a query list (JSON, docs/formats/query_list_v1.md). The list names image or feature files,
// which this function does not read; their paths are relative to the list. Throws Error(kBadInput)
// that names file and field.
std::vector<EvalQuery> ReadQueryList(const std::string& path);
void WriteQueryList(const std::string& path, const std::vector<EvalQuery>& queries);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVAL_QUERY_H_
