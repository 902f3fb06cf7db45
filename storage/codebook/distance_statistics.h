// Statistics of a codebook on the distances between descriptors of the same landmark.
#ifndef CAIRN_STORAGE_CODEBOOK_DISTANCE_STATISTICS_H_
#define CAIRN_STORAGE_CODEBOOK_DISTANCE_STATISTICS_H_

#include "storage/codebook/codebook.h"

namespace cairn {

// Returns the distance (not squared, projected space) below which the fraction `quantile` of a
// codebook's same-landmark distances lies. Interpolates linearly between the stored quantiles and
// clamps `quantile` to [0.05, 0.95]. Throws Error(kMapDamaged) if the codebook has no such
// statistics.
double SameLandmarkDistance(const Codebook& codebook, double quantile);

}  // namespace cairn

#endif  // CAIRN_STORAGE_CODEBOOK_DISTANCE_STATISTICS_H_
