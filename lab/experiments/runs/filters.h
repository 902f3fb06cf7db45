// The outlier filters that experiments 12, 13 and 20 compare. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_FILTERS_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_FILTERS_H_

#include "engine/voting/voting_options.h"
#include "lab/rivals/covisibility_filter.h"

namespace cairn {

struct NamedFilter {
  const char* name;
  // Returns the options with this filter in place of their own.
  VotingOptions (*with_filter)(VotingOptions);
};

inline VotingOptions WithVoting(VotingOptions options, OutlierFilter filter) {
  options.filter = filter;
  return options;
}

inline constexpr NamedFilter kVoting = {
    "voting in 4D", [](VotingOptions o) { return WithVoting(o, OutlierFilter::kVoting4d); }};
inline constexpr NamedFilter kVotingFlat = {
    "voting in 3D", [](VotingOptions o) { return WithVoting(o, OutlierFilter::kVoting3d); }};
inline constexpr NamedFilter kCovisible = {"covisibility", WithCovisibility};

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_FILTERS_H_
