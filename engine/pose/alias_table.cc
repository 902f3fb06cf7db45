#include "engine/pose/alias_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cairn {

AliasTable::AliasTable(const std::vector<double>& weights) : entries_(weights.size()) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double scale = sum > 0.0 ? static_cast<double>(weights.size()) / sum : 0.0;
  std::vector<double> shares(weights.size(), 1.0);  // Scaled to a mean of 1.
  std::vector<int> below, above;
  for (int i = 0; i < size(); ++i) {
    shares[i] = sum > 0.0 ? weights[i] * scale : 1.0;
    entries_[i].alias = i;  // Kept by numbers that need no alias.
    (shares[i] < 1.0 ? below : above).push_back(i);
  }
  // Fills up a number below the mean from a number above, which may thereby fall below the mean.
  while (!below.empty() && !above.empty()) {
    const int poor = below.back(), rich = above.back();
    below.pop_back();
    entries_[poor] = {static_cast<uint32_t>(std::ldexp(shares[poor], 32)), rich};
    shares[rich] -= 1.0 - shares[poor];
    if (shares[rich] < 1.0) {
      above.pop_back();
      below.push_back(rich);
    }
  }
}

}  // namespace cairn
