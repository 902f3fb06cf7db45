// Lengths for scale bars and grids.
#ifndef CAIRN_EVAL_PICTURES_ROUND_DOWN_125_H_
#define CAIRN_EVAL_PICTURES_ROUND_DOWN_125_H_

#include <cmath>

namespace cairn {

// The largest of ..., 0.5, 1, 2, 5, 10, ... that is at most `value`, which is positive.
inline double RoundDown125(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0}) {
    if (step * decade <= value) {
      return step * decade;
    }
  }
  return decade;
}

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_ROUND_DOWN_125_H_
