// The outlier filters that 12 and 13 compare; private to experiments.
#ifndef CAIRN_EVAL_EXPERIMENTS_RUNS_FILTERS_H_
#define CAIRN_EVAL_EXPERIMENTS_RUNS_FILTERS_H_

#include "engine/voting/voting_options.h"

namespace cairn {

struct NamedFilter {
  const char* name;
  OutlierFilter filter;
};
inline constexpr NamedFilter kVoting = {"voting in 4D", OutlierFilter::kVoting4d};
inline constexpr NamedFilter kVotingFlat = {"voting in 3D", OutlierFilter::kVoting3d};
inline constexpr NamedFilter kCovisible = {"covisibility", OutlierFilter::kCovisibility};

}  // namespace cairn

#endif  // CAIRN_EVAL_EXPERIMENTS_RUNS_FILTERS_H_
