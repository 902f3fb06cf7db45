#include "engine/pose/evidence_model.h"

#include <cmath>

namespace cairn {

double TraitModel::LogRatio(double deviation) const {
  const double z = deviation / scale;
  return -weight * std::log1p(z * z);
}

}  // namespace cairn
