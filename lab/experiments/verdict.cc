#include "lab/experiments/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace cairn {
namespace {

constexpr Verdict kVerdicts[] = {Verdict::kHolds, Verdict::kDoesNotHold, Verdict::kUndecided,
                                 Verdict::kNotBuilt};

}  // namespace

const char* VerdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kHolds:
      return "holds";
    case Verdict::kDoesNotHold:
      return "does not hold";
    case Verdict::kUndecided:
      return "undecided";
    case Verdict::kNotBuilt:
      return "not built";
  }
  return "undecided";
}

Verdict VerdictFromName(const std::string& name) {
  for (const Verdict verdict : kVerdicts) {
    if (name == VerdictName(verdict)) {
      return verdict;
    }
  }
  throw Error(ErrorCode::kBadInput, "there is no verdict '" + name + "'");
}

Verdict JudgeGreater(const Interval& interval, double threshold) {
  if (interval.low > threshold) {
    return Verdict::kHolds;
  }
  return interval.high < threshold ? Verdict::kDoesNotHold : Verdict::kUndecided;
}

Verdict JudgeSmaller(const Interval& interval, double threshold) {
  return JudgeGreater({-interval.value, -interval.high, -interval.low}, -threshold);
}

Verdict JudgeEqual(const Interval& difference, double margin) {
  if (difference.low >= -margin && difference.high <= margin) {
    return Verdict::kHolds;
  }
  return difference.low > margin || difference.high < -margin ? Verdict::kDoesNotHold
                                                              : Verdict::kUndecided;
}

Verdict JudgeAll(const std::vector<Verdict>& parts) {
  const auto any = [&](Verdict verdict) {
    return std::find(parts.begin(), parts.end(), verdict) != parts.end();
  };
  if (any(Verdict::kNotBuilt)) {
    return Verdict::kNotBuilt;
  }
  if (any(Verdict::kDoesNotHold)) {
    return Verdict::kDoesNotHold;
  }
  return parts.empty() || any(Verdict::kUndecided) ? Verdict::kUndecided : Verdict::kHolds;
}

std::string DifferenceText(const Interval& difference, int digits) {
  return fmt::format("{:+.{}f} [{:+.{}f}, {:+.{}f}]", difference.value, digits, difference.low,
                     digits, difference.high, digits);
}

std::string IntervalText(const Interval& interval, int digits) {
  return fmt::format("{:.{}f} [{:.{}f}, {:.{}f}]", interval.value, digits, interval.low, digits,
                     interval.high, digits);
}

}  // namespace cairn
