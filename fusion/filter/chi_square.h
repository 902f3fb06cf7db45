// Quantiles of the chi-square distribution, for gates.
#ifndef CAIRN_FUSION_FILTER_CHI_SQUARE_H_
#define CAIRN_FUSION_FILTER_CHI_SQUARE_H_

namespace cairn::fusion {

// Returns the quantile of the chi-square distribution with `degrees_of_freedom` (positive). The
// probability is that of a standard normal variable below `normal_quantile`: 1.645 for 95 %, 2.326
// for 99 %, 3.09 for 99.9 %. Uses the approximation of Wilson and Hilferty (1931): within 1.5 % for
// probabilities of 95 to 99.9 %; exact for 2 degrees of freedom.
double ChiSquareQuantile(int degrees_of_freedom, double normal_quantile);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_CHI_SQUARE_H_
