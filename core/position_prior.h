// A rough position, from which a query is localized.
#ifndef CAIRN_CORE_POSITION_PRIOR_H_
#define CAIRN_CORE_POSITION_PRIOR_H_

#include <optional>
#include <string_view>

#include "core/geodesy.h"

namespace cairn {

// Where a prior comes from.
enum class PriorSource {
  kClient,  // The client states it.
  kPhoto,   // The EXIF of the query's photo.
};
// "request" or "exif".
const char* PriorSourceName(PriorSource source);
std::optional<PriorSource> PriorSourceFromName(std::string_view name);

// A rough position, as a GPS receiver reports it.
struct PositionPrior {
  static constexpr double kMaxAccuracyM = 100e3;

  Geodetic position;
  double accuracy_m = 15.0;  // Radius that contains the true position with 68 % probability.
  // Standard deviation of the height; empty if the height is unknown or untrusted.
  std::optional<double> height_sigma_m = {};
  PriorSource source = PriorSource::kClient;
};

}  // namespace cairn

#endif  // CAIRN_CORE_POSITION_PRIOR_H_
