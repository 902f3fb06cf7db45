// How accurate the content of a session is, estimated when it was ingested.
#ifndef CAIRN_STORAGE_MAP_SESSION_ACCURACY_H_
#define CAIRN_STORAGE_MAP_SESSION_ACCURACY_H_

#include <vector>

namespace cairn {

// 68 % radii (core/radius68.h). docs/math/localization.md, "The accuracy of a map", says how they
// are estimated.
struct SessionAccuracy {
  // How far parts of the session disagree with each other and with the map that it joined. Poses of
  // queries in the map err by as much, in addition to what their matches predict.
  double in_map_m = 0.0;
  // How far the session is from its true place and direction on Earth. All poses there share this
  // error.
  double on_earth_m = 0.0;
  double on_earth_rad = 0.0;

  bool operator==(const SessionAccuracy&) const = default;
};

// Returns whether the numbers are finite, not negative and below the size of the Earth.
bool IsValid(const SessionAccuracy& accuracy);

// The root mean square of each member. There must be at least one.
SessionAccuracy RootMeanSquare(const std::vector<SessionAccuracy>& accuracies);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_SESSION_ACCURACY_H_
