// How much a measure depends on which queries were asked, and whether two methods differ.
//
// The definitions are in docs/math/metrics.md, section "Intervals".
#ifndef CAIRN_EVAL_EVALUATION_BOOTSTRAP_H_
#define CAIRN_EVAL_EVALUATION_BOOTSTRAP_H_

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace cairn {

// Value with a 95 % bootstrap interval: the 2.5 and 97.5 percentiles over 1,000 resamplings of the
// queries. Not a number where there is nothing to measure.
struct Interval {
  double value = 0.0, low = 0.0, high = 0.0;
};

// A measure of a multiset of queries, given by index, never empty. Not a number if undefined.
using IndexStatistic = std::function<double(std::span<const size_t>)>;

// `statistic` of the queries 0 ... num_queries - 1, each once, with its percentile bootstrap
// interval. Resamplings where the statistic is not a number do not count. The same resamplings for
// every statistic: a statistic that is the difference of two methods on the drawn queries makes a
// paired bootstrap.
Interval Bootstrap(size_t num_queries, const IndexStatistic& statistic);

// Same, where queries that depend on each other (frames of one sequence) are drawn together:
// `group_of_query` numbers the groups, in any way. As many groups are drawn as there are.
Interval GroupBootstrap(const std::vector<int>& group_of_query, const IndexStatistic& statistic);

// Share `num_yes` / `num` with its 95 % Wilson score interval. num > 0.
Interval WilsonInterval(int num_yes, int num);

// `share` in [0, 1]; linear between the two nearest ranks. `values` must not be empty.
double Quantile(std::vector<double> values, double share);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_BOOTSTRAP_H_
