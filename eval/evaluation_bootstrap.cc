#include "eval/evaluation_bootstrap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include "core/check.h"
#include "core/statistics.h"

namespace cairn {
namespace {

constexpr int kNumResamplings = 1000;
constexpr uint64_t kBootstrapSeed = 1;
constexpr double kLowQuantile = 0.025, kHighQuantile = 0.975;

}  // namespace

Interval GroupBootstrap(const std::vector<int>& group_of_query, const IndexStatistic& statistic) {
  Interval interval;
  interval.value = interval.low = interval.high = std::numeric_limits<double>::quiet_NaN();
  if (group_of_query.empty()) {
    return interval;
  }
  std::map<int, std::vector<size_t>> queries_of_group;
  for (size_t i = 0; i < group_of_query.size(); ++i) {
    queries_of_group[group_of_query[i]].push_back(i);
  }
  std::vector<const std::vector<size_t>*> groups;
  for (const auto& [group, queries] : queries_of_group) {
    groups.push_back(&queries);
  }
  std::vector<size_t> sample(group_of_query.size());
  std::iota(sample.begin(), sample.end(), size_t{0});
  interval.value = interval.low = interval.high = statistic(sample);
  if (std::isnan(interval.value)) {
    return interval;
  }

  std::mt19937_64 generator(kBootstrapSeed);
  std::uniform_int_distribution<size_t> draw(0, groups.size() - 1);
  std::vector<double> values;
  for (int i = 0; i < kNumResamplings; ++i) {
    sample.clear();
    for (size_t j = 0; j < groups.size(); ++j) {
      const std::vector<size_t>& queries = *groups[draw(generator)];
      sample.insert(sample.end(), queries.begin(), queries.end());
    }
    if (const double value = statistic(sample); !std::isnan(value)) {
      values.push_back(value);
    }
  }
  if (!values.empty()) {
    std::sort(values.begin(), values.end());
    interval.low = Quantile(values, kLowQuantile);
    interval.high = Quantile(values, kHighQuantile);
  }
  return interval;
}

Interval Bootstrap(size_t num_queries, const IndexStatistic& statistic) {
  std::vector<int> each_its_own(num_queries);
  std::iota(each_its_own.begin(), each_its_own.end(), 0);
  return GroupBootstrap(each_its_own, statistic);
}

Interval WilsonInterval(int num_yes, int num) {
  constexpr double kZ = 1.959964;  // 97.5 % quantile of the normal distribution.
  const double n = num, p = num_yes / n, z2 = kZ * kZ;
  const double center = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half = kZ / (1.0 + z2 / n) * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  return {p, std::max(0.0, center - half), std::min(1.0, center + half)};
}

}  // namespace cairn
