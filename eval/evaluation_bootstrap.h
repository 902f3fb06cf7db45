// Confidence intervals: how far a measure depends on the choice of queries, and whether two methods
// differ.
//
// docs/math/metrics.md, section "Intervals", has the definitions.
#ifndef CAIRN_EVAL_EVALUATION_BOOTSTRAP_H_
#define CAIRN_EVAL_EVALUATION_BOOTSTRAP_H_

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace cairn {

// A value with a 95 % bootstrap interval: the 2.5 and 97.5 percentiles over 1,000 resamplings of
// the queries. NaN if there is nothing to measure.
struct Interval {
  double value = 0.0, low = 0.0, high = 0.0;
};

// A measure of a non-empty multiset of queries, given by index. Returns NaN if the measure is
// undefined.
using IndexStatistic = std::function<double(std::span<const size_t>)>;

// Evaluates `statistic` on the queries 0 ... num_queries - 1 and adds a percentile bootstrap
// interval. Ignores resamplings for which the statistic is NaN. All statistics use the same
// resamplings. A statistic that computes the difference of two methods on the drawn queries
// therefore gives a paired bootstrap.
Interval Bootstrap(size_t num_queries, const IndexStatistic& statistic);

// Like Bootstrap, for queries that depend on each other (frames of one sequence): the bootstrap
// draws whole groups, as many as there are. `group_of_query` numbers the groups arbitrarily.
Interval GroupBootstrap(const std::vector<int>& group_of_query, const IndexStatistic& statistic);

// The share `num_yes` / `num` with its 95 % Wilson score interval. num > 0.
Interval WilsonInterval(int num_yes, int num);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_BOOTSTRAP_H_
