// Decides whether a claim holds here, by rules on intervals that can come out either way.
#ifndef CAIRN_LAB_EXPERIMENTS_VERDICT_H_
#define CAIRN_LAB_EXPERIMENTS_VERDICT_H_

#include <string>
#include <vector>

#include "eval/evaluation_bootstrap.h"

namespace cairn {

enum class Verdict {
  kHolds,
  kDoesNotHold,
  kUndecided,  // The interval allows both outcomes.
  kNotBuilt,   // The subject of the claim is not in this build.
};

const char* VerdictName(Verdict verdict);  // "holds", "does not hold", "undecided", "not built".
// Throws Error(kBadInput) if the name is unknown.
Verdict VerdictFromName(const std::string& name);

// Judges the claim "the quantity is greater than `threshold`" by the quantity's interval (usually
// of a paired difference). The claim holds if the whole interval is greater, and does not hold if
// the whole interval is smaller. Undecided if a value is not a number.
Verdict JudgeGreater(const Interval& interval, double threshold = 0.0);

// Judges the claim "the quantity is smaller than `threshold`" in the same way.
Verdict JudgeSmaller(const Interval& interval, double threshold);

// Judges the claim "there is no relevant difference". The claim holds if the whole interval is
// within +-margin, and does not hold if the whole interval is outside on one side.
Verdict JudgeEqual(const Interval& difference, double margin);

// Judges a claim with several parts. The claim holds if all parts hold, does not hold if one part
// does not, and is undecided otherwise. Without parts: undecided.
Verdict JudgeAll(const std::vector<Verdict>& parts);

// Returns "+0.031 [+0.012, +0.050]": the value and its 95 % interval, with signs for a difference.
std::string DifferenceText(const Interval& difference, int digits = 3);
std::string IntervalText(const Interval& interval, int digits = 3);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_VERDICT_H_
