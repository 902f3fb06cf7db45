// All options of a query, nested by stage.
#ifndef CAIRN_ENGINE_LOCALIZER_OPTIONS_H_
#define CAIRN_ENGINE_LOCALIZER_OPTIONS_H_

#include <cstdint>

#include "engine/answer/answer_options.h"
#include "engine/matching/matching_options.h"
#include "engine/places/places_options.h"
#include "engine/pose/pose_options.h"
#include "engine/refinement/refinement_options.h"
#include "engine/tiles/prior_options.h"
#include "engine/tiles/tiles_options.h"
#include "engine/voting/voting_options.h"

namespace cairn {

struct LocalizerOptions {
  PriorOptions prior;
  PlacesOptions places;
  TilesOptions tiles;
  MatchingOptions matching;
  VotingOptions voting;
  PoseOptions pose;
  RefinementOptions refinement;
  AnswerOptions answer;

  // Number of threads that a query may use while no other query needs them, including its own. The
  // other threads are shared by all queries of a localizer. At least 1. The answer does not depend
  // on num_threads.
  int num_threads = 1;

  // Seed of all randomness in a query; the same seed gives the same answer.
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_LOCALIZER_OPTIONS_H_
