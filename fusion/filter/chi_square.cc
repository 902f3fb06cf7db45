#include "fusion/filter/chi_square.h"

#include <cmath>

namespace cairn::fusion {

double ChiSquareQuantile(int degrees_of_freedom, double normal_quantile) {
  if (degrees_of_freedom == 2) {
    const double exceedance = 0.5 * std::erfc(normal_quantile / std::sqrt(2.0));
    return -2.0 * std::log(exceedance);
  }
  const double k = degrees_of_freedom;
  const double spread = 2.0 / (9.0 * k);
  return k * std::pow(1.0 - spread + normal_quantile * std::sqrt(spread), 3);
}

}  // namespace cairn::fusion
