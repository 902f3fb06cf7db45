// Changes the focal lengths that queries state: correct, wrong, or unknown.
#ifndef CAIRN_EVAL_STATED_FOCAL_H_
#define CAIRN_EVAL_STATED_FOCAL_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "eval/eval_query.h"

namespace cairn {

struct StatedFocalOptions {
  // Relative error of the stated focal length, in [0, 0.5]. The seed and the query's name decide
  // whether the length is too long or too short.
  double error = 0.0;
  // The relative standard deviation that the queries state with the focal length; nullopt if they
  // state none.
  std::optional<double> sigma = std::nullopt;
  // If true, queries state only the size of their images.
  bool withheld = false;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Changes the queries' own cameras; other cameras of a rig stay unchanged. Validates the options.
void StateFocalLengths(const StatedFocalOptions& options, std::vector<EvalQuery>* queries);

}  // namespace cairn

#endif  // CAIRN_EVAL_STATED_FOCAL_H_
