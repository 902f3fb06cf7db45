// What queries say about their focal length: the truth, something else, or nothing.
#ifndef CAIRN_EVAL_STATED_FOCAL_H_
#define CAIRN_EVAL_STATED_FOCAL_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "eval/eval_query.h"

namespace cairn {

struct StatedFocalOptions {
  // The stated focal length is so much too long or too short, relative, [0, 0.5]; which of the two
  // depends on the seed and the query's name.
  double error = 0.0;
  // The standard deviation that the queries state along with it, relative; nothing: none.
  std::optional<double> sigma = std::nullopt;
  // Nothing of the camera is told but the size of its images.
  bool withheld = false;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Changes the cameras of the queries, but not those of the rest of a rig. Validates the options.
void StateFocalLengths(const StatedFocalOptions& options, std::vector<EvalQuery>* queries);

}  // namespace cairn

#endif  // CAIRN_EVAL_STATED_FOCAL_H_
