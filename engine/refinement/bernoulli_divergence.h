// Measures how unlikely a count is.
#ifndef CAIRN_ENGINE_REFINEMENT_BERNOULLI_DIVERGENCE_H_
#define CAIRN_ENGINE_REFINEMENT_BERNOULLI_DIVERGENCE_H_

#include <cmath>

namespace cairn {

// Returns the Kullback-Leibler divergence of two coins, with 0 ln 0 = 0; `p` lies in (0, 1). For q
// > p, n tosses of the coin p give a share of q or more with a probability of at most exp(-n times
// this divergence) (Chernoff).
inline double BernoulliDivergence(double q, double p) {
  const double heads = q > 0.0 ? q * std::log(q / p) : 0.0;
  const double tails = q < 1.0 ? (1.0 - q) * std::log((1.0 - q) / (1.0 - p)) : 0.0;
  return heads + tails;
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_BERNOULLI_DIVERGENCE_H_
