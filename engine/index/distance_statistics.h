// What a codebook knows about how far apart the descriptors of one landmark lie.
#ifndef CAIRN_ENGINE_INDEX_DISTANCE_STATISTICS_H_
#define CAIRN_ENGINE_INDEX_DISTANCE_STATISTICS_H_

#include "storage/codebook/codebook.h"

namespace cairn {

// Distance (not squared, projected space) below which the fraction `quantile` of a codebook's
// same-landmark distances lies; linear between the stored quantiles, clamped to [0.05, 0.95].
// Throws Error(kMapDamaged) if the codebook has no such statistics.
double SameLandmarkDistance(const Codebook& codebook, double quantile);

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_DISTANCE_STATISTICS_H_
