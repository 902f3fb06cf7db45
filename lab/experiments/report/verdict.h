// Whether a claim holds here: rules on intervals that can fall either way.
#ifndef CAIRN_LAB_EXPERIMENTS_REPORT_VERDICT_H_
#define CAIRN_LAB_EXPERIMENTS_REPORT_VERDICT_H_

#include <string>
#include <vector>

#include "eval/evaluation_bootstrap.h"

namespace cairn {

enum class Verdict {
  kHolds,
  kDoesNotHold,
  kUndecided,  // The interval leaves it open.
  kNotBuilt,   // What the claim is about is not in this build.
};

const char* VerdictName(Verdict verdict);  // "holds", "does not hold", "undecided", "not built".
// Throws Error(kBadInput) on another name.
Verdict VerdictFromName(const std::string& name);

// Of the claim "the quantity is greater than `threshold`", with the interval of the quantity
// (usually a paired difference): holds if all of it is greater, does not hold if all of it is
// smaller. Undecided if it is not a number.
Verdict JudgeGreater(const Interval& interval, double threshold = 0.0);

// Of the claim "the quantity is smaller than `threshold`", likewise.
Verdict JudgeSmaller(const Interval& interval, double threshold);

// Of the claim "there is no difference to speak of": holds if all of the interval is within
// +-margin, does not hold if all of it is outside on one side.
Verdict JudgeEqual(const Interval& difference, double margin);

// Of a claim with several parts: holds if all do; does not hold if any does not; undecided
// otherwise. Empty: undecided.
Verdict JudgeAll(const std::vector<Verdict>& parts);

// "+0.031 [+0.012, +0.050]": value and 95 % interval, with sign if it is a difference.
std::string DifferenceText(const Interval& difference, int digits = 3);
std::string IntervalText(const Interval& interval, int digits = 3);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_REPORT_VERDICT_H_
