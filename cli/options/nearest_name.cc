#include "cli/options/nearest_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace cairn {
namespace {

// Longer words are no misspelled names; a distance costs the product of the lengths.
constexpr size_t kMaxWordBytes = 64;

// Fewer letters say too little of what follows.
constexpr size_t kLeastLettersOfBeginning = 3;

// Dashes at the front are no letters that anybody mistypes.
std::string_view WithoutDashes(std::string_view name) {
  return name.substr(std::min(name.find_first_not_of('-'), name.size()));
}

bool OneBeginsWithTheOther(std::string_view a, std::string_view b) {
  const size_t shared = std::min(a.size(), b.size());
  return shared >= kLeastLettersOfBeginning && a.substr(0, shared) == b.substr(0, shared);
}

// Orders names by how well they fit; the largest number is no fit.
size_t Misfit(std::string_view word, std::string_view name) {
  const std::string_view a = WithoutDashes(word), b = WithoutDashes(name);
  const size_t distance = EditDistance(a, b);
  if (3 * distance <= std::max(a.size(), b.size())) {
    return distance;
  }
  return OneBeginsWithTheOther(a, b) ? kMaxWordBytes + distance
                                     : std::numeric_limits<size_t>::max();
}

}  // namespace

size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> before_last, last, row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    before_last = std::exchange(last, row);
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = last[j] + (a[i] == b[j] ? 0 : 1);
      row[j + 1] = std::min({replaced, row[j] + 1, last[j + 1] + 1});
      if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j]) {
        row[j + 1] = std::min(row[j + 1], before_last[j - 1] + 1);
      }
    }
  }
  return row[b.size()];
}

std::string DidYouMean(std::string_view word, const std::vector<std::string>& names) {
  if (word.size() > kMaxWordBytes || names.empty()) {
    return "";
  }
  const auto nearest = std::min_element(
      names.begin(), names.end(),
      [&](const auto& a, const auto& b) { return Misfit(word, a) < Misfit(word, b); });
  return Misfit(word, *nearest) == std::numeric_limits<size_t>::max()
             ? ""
             : fmt::format("; did you mean '{}'?", *nearest);
}

}  // namespace cairn
