#include "engine/localizer_options.h"

#include "core/require.h"

namespace cairn {

void LocalizerOptions::Validate() const {
  RequireWithin("num_threads", num_threads, 1, 1024);
  prior.Validate();
  places.Validate();
  tiles.Validate();
  matching.Validate();
  voting.Validate();
  pose.Validate();
  refinement.Validate();
  answer.Validate();
}

}  // namespace cairn
